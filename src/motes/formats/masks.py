"""Masks: a folder with a picture of each frame, PNG, white where the objects are.

A picture has the name of the frame's image. An object without a mask of its own fills its ellipse.
"""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np

from motes.core.geometry import Ellipse
from motes.core.types import Flags
from motes.formats import runs
from motes.formats.recording import Recording
from motes.formats.shapes import stem_of
from motes.formats.visibility import visible
from motes.output.overlay import png


def write(recorded: Recording) -> Iterator[tuple[str, bytes]]:
    """Yield the names and contents of the pictures."""
    height, width = recorded.head.height, recorded.head.width
    for row in recorded:
        white = np.zeros((height, width), np.bool_)
        for each in visible(row):
            if each.mask is None:
                white |= _inside(each.ellipse, height, width)
            else:
                white |= runs.decode(each.mask, height, width)
        yield f"{stem_of(row)}.png", png(255 * white.astype(np.uint8))


def _inside(ellipse: Ellipse, height: int, width: int) -> Flags:
    """Return which pixels (height, width) have their centers in an ellipse."""
    y, x = np.ogrid[:height, :width]
    cos, sin = math.cos(ellipse.theta), math.sin(ellipse.theta)
    along = (x - ellipse.x) * cos + (y - ellipse.y) * sin
    across = (y - ellipse.y) * cos - (x - ellipse.x) * sin
    inside: Flags = (along / ellipse.a) ** 2 + (across / ellipse.b) ** 2 <= 1
    return inside
