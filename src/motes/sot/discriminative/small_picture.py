"""A frame as a small gray picture: what shows the motion of the camera and the light."""

from __future__ import annotations

import math
from functools import cache

import numpy as np

from motes.core.frame import Frame
from motes.core.geometry import Ellipse
from motes.core.types import Floats, Singles
from motes.cues.fourier import fast_length
from motes.cues.search_window import cut

COLUMNS = 96
"""Largest number of rows and of columns."""


def small_picture(frame: Frame) -> Singles:
    """Return the sums of red, green and blue at evenly spaced points of a frame, (h, w)."""
    rows, columns = small_size(frame.height, frame.width)
    step = frame.width / columns, frame.height / rows
    center = Ellipse((frame.width - 1) / 2, (frame.height - 1) / 2, 1.0, 1.0)
    out: Singles = cut(frame, center, step, (rows, columns)).sum(axis=0)
    return out


@cache
def small_size(height: int, width: int) -> tuple[int, int]:
    """Return the number of rows and columns of the small picture of a frame.

    Fourier transforms of these sizes are fast.
    """
    shrink = min(1.0, COLUMNS / max(height, width))
    rows, columns = (max(round(side * shrink), 1) for side in (height, width))
    return fast_length(rows), fast_length(columns)


def overlap(before: Singles, now: Singles, shift: Floats, frame: Frame) -> tuple[Singles, Singles]:
    """Return what two small pictures both show, if the scene has moved by a shift.

    Parameters
    ----------
    before, now
        (h, w), the pictures.
    shift
        (2,), x and y in pixels of the frames.
    frame
        One of the frames, which are of one size.
    """
    rows, columns = now.shape
    across = round(float(shift[0]) * columns / frame.width)
    down = round(float(shift[1]) * rows / frame.height)

    def part(picture: Singles, right: int, low: int) -> Singles:
        left, top = max(right, 0), max(low, 0)
        return picture[top : max(rows + min(low, 0), 0), left : max(columns + min(right, 0), 0)]

    return part(before, -across, -down), part(now, across, down)


def difference(pictures: tuple[Singles, Singles]) -> float:
    """Return the mean difference of two pictures; it is infinite if they show nothing."""
    before, now = pictures
    return float(np.abs(now - before).mean()) if now.size else math.inf
