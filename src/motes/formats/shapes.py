"""The part of an object inside the picture, as annotation tools measure it.

Their coordinates begin at the upper left corner of the picture, ours at the first pixel's center.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from pathlib import Path
from typing import NamedTuple

from motes.core.geometry import Box, Ellipse, area, clipped
from motes.core.track import Track
from motes.formats.recording import Recording
from motes.formats.visibility import SHOWN
from motes.rows.schema import FrameRow, Header

MIN_AREA = 0.01
"""Smallest area inside the frame of an object that is annotated, in square pixels."""


class Corners(NamedTuple):
    """The sides of a box, in pixels."""

    left: float
    top: float
    right: float
    bottom: float

    @property
    def ellipse(self) -> Ellipse:
        """The upright ellipse inside."""
        return Ellipse.from_box(
            (self.left, self.top, self.right - self.left, self.bottom - self.top)
        )


def box_of_rectangle(inside: Ellipse) -> Box:
    """Return the upright box around a rectangle, upright or turned, by the ellipse inside it."""
    x, y, a, b, theta = inside
    cos, sin = abs(math.cos(theta)), abs(math.sin(theta))
    width, height = 2 * (a * cos + b * sin), 2 * (a * sin + b * cos)
    return Box(x - (width - 1) / 2, y - (height - 1) / 2, width, height)


def visible_box(each: Track, head: Header) -> Corners | None:
    """Return the part of an object's box inside the frame; None if it is not annotated."""
    if each.status not in SHOWN:
        return None
    x, y, width, height = each.box
    whole = Corners(round(x, 2), round(y, 2), round(x + width, 2), round(y + height, 2))
    left, right = (min(max(end, 0.0), head.width) for end in (whole.left, whole.right))
    top, bottom = (min(max(end, 0.0), head.height) for end in (whole.top, whole.bottom))
    cut = Corners(left, top, right, bottom)
    if left >= right or top >= bottom:
        return None
    if cut == whole:
        return cut
    # If only a corner of the box is inside the frame, the ellipse may still be outside. The first
    # pixel's center is at 0 in an ellipse, and at 0.5 in coordinates of its corners.
    inside = clipped(each.ellipse.polygon() + 0.5, head.width, head.height)
    return cut if area(inside) >= MIN_AREA else None


def classes_of(recorded: Recording) -> dict[int, str]:
    """Return the class of each identity: that of its last row."""
    usual = recorded.head.label
    return {
        each.identity: usual if each.label is None else each.label
        for row in recorded
        for each in row.objects
    }


def labels_of(classes: Iterable[str], head: Header) -> list[str]:
    """Return all classes in the order of their first identities; at least one."""
    return list(dict.fromkeys(classes)) or [head.label]


def label_or_none(name: str | None, usual: str) -> str | None:
    """Return a class that a file names, or None for the usual one."""
    return None if name in (None, "", usual) else name


def image_of(row: FrameRow) -> str:
    """Return the name of a frame's image; of a video, that which CVAT gives to the frame."""
    return row.file or f"frame_{row.frame:06d}.png"


def stem_of(row: FrameRow) -> str:
    """Return the name of a frame's image without folders and ending."""
    return Path(image_of(row)).stem
