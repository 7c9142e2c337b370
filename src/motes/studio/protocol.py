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

from motes.studio.commands import Command
from motes.studio.messages import (
    DoubtfulFrame,
    FilmCard,
    Message,
    Open,
    Presets,
    SessionCard,
    WholeSession,
)

LARGEST_MESSAGE = 1 << 18
"""Bytes that a message from the page may have."""

_decoder = msgspec.json.Decoder(Command)
_encoder = msgspec.json.Encoder()


def decode(text: str | bytes) -> Command:
    """Return the command in a message; raise a `msgspec.MsgspecError` if it is none."""
    command: Command = _decoder.decode(text)
    return command


def encode(message: Message) -> str:
    """Return the text of a message."""
    return _encoder.encode(message).decode()


def schema() -> dict[str, Any]:
    """Return the JSON schema of commands and messages, by the names of their types."""
    answers = (WholeSession, SessionCard, FilmCard, Presets, DoubtfulFrame)
    kinds = (Command, Message, Open, *answers)
    _, definitions = msgspec.json.schema_components(kinds, ref_template="#/$defs/{name}")
    return {"$defs": definitions}
