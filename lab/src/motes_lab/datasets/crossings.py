"""Crossings of lines in films, found by eye: the truth of counts."""

from __future__ import annotations

from typing import Annotated

from msgspec import Meta

from motes.core.config import Config, from_dict, from_toml

Frame = Annotated[int, Meta(ge=0)]


class CrossedLine(Config, frozen=True):
    """A line, and the frames in which it is crossed.

    Attributes
    ----------
    points
        Its two ends: x1, y1, x2, y2, in pixels.
    left, right
        The frames of the crossings to each side, as seen from the first point towards the second.
    """

    points: tuple[float, float, float, float]
    left: tuple[Frame, ...] = ()
    right: tuple[Frame, ...] = ()


class CountedClip(Config, frozen=True):
    """A film with lines whose crossings are known.

    Attributes
    ----------
    file
        Its name in the folder of films.
    line
        The lines.
    """

    file: str
    line: Annotated[tuple[CrossedLine, ...], Meta(min_length=1)]


class CountedClips(Config, frozen=True):
    """Films with known crossings. In TOML: [[clip]] with [[clip.line]].

    Attributes
    ----------
    clip
        The films.
    """

    clip: Annotated[tuple[CountedClip, ...], Meta(min_length=1)]


def parse_crossings(text: str, name: str) -> CountedClips:
    """Return the clips in a TOML text; raise a ConfigError if it is not valid."""
    clips: CountedClips = from_dict(from_toml(text, name), CountedClips)
    return clips
