"""Boxes by hand of all objects that look like one, in some frames of a film."""

from __future__ import annotations

from typing import Annotated

from msgspec import Meta

from motes.core.config import Config, from_dict, from_toml

Corners = tuple[float, float, float, float]


class MarkedFrame(Config, frozen=True):
    """The boxes in a frame.

    Attributes
    ----------
    index
        The frame's index, from 0.
    boxes
        The boxes: x, y, width, height.
    """

    index: Annotated[int, Meta(ge=0)]
    boxes: tuple[Corners, ...]


class Team(Config, frozen=True):
    """All objects that look like one, in some frames.

    Attributes
    ----------
    sequence
        The name of the sequence.
    start
        The frame in which the one is chosen.
    like
        Its box there.
    frame
        The frames with boxes.
    """

    sequence: str
    start: Annotated[int, Meta(ge=0)]
    like: Corners
    frame: Annotated[tuple[MarkedFrame, ...], Meta(min_length=1)]


def parse_team(text: str, name: str) -> Team:
    """Return the boxes in a TOML text; raise a ConfigError if it is not valid."""
    team: Team = from_dict(from_toml(text, name), Team)
    return team
