"""The protocol of the studio: all that the page and the server send each other.

A WebSocket carries the `Command`s of `commands` from the page and the `Message`s of `messages` to
it, each a JSON object whose `type` names it. Every command has an `id`, and is answered by one
`Reply` with that id, after the state and the rows that have changed with it. HTTP carries films,
pictures and files, and the JSON of films, sessions, doubtful frames and single overlays. Both sides
are tested against `schema`.

Places are in pixels of the film from 0, angles in radians, times in seconds. Frames count from 0. A
region has four numbers, a box x, y, width, height; or five, an ellipse x, y, a, b, theta: its
center, its half-axes, and the angle of the first one.
"""

from __future__ import annotations

from typing import Any

import msgspec

from motes import ConfigError
from motes_studio import messages
from motes_studio.commands import Command, Number
from motes_studio.messages import Message

LARGEST_MESSAGE = 1 << 18
"""Bytes that a message from the page may have."""

NOBODY = -1
"""The id of the answer to a message without one."""


class _Numbered(msgspec.Struct):
    id: Number = NOBODY


_decoder = msgspec.json.Decoder(Command)
_encoder = msgspec.json.Encoder()


def decode(text: str) -> Command:
    """Return the command in a message; raise a ConfigError if it is none, or too large."""
    if len(text) > LARGEST_MESSAGE:
        raise ConfigError(f"A message has {LARGEST_MESSAGE} bytes at most.")
    try:
        command: Command = _decoder.decode(text)
    except (msgspec.MsgspecError, RecursionError) as error:
        raise ConfigError(f"This message is no command: {error}.") from None
    return command


def id_of(text: str) -> int:
    """Return the id of a message that may be no command; -1 if it has none."""
    try:
        return msgspec.json.decode(text, type=_Numbered).id
    except (msgspec.MsgspecError, RecursionError):
        return NOBODY


def encode(message: Message) -> str:
    """Return the text of a message."""
    return _encoder.encode(message).decode()


def schema() -> dict[str, Any]:
    """Return the JSON schema of commands and messages, by the names of their types."""
    whole = (messages.Open, messages.WholeSession, messages.SessionCard, messages.FilmCard)
    kinds = (Command, Message, *whole, messages.Presets, messages.DoubtfulFrame)
    _, definitions = msgspec.json.schema_components(kinds, ref_template="#/$defs/{name}")
    return {"$defs": definitions}
