"""A frame as a small gray picture: what shows the motion of the camera and the light."""

from __future__ import annotations

from functools import cache

from motes.core.frame import Frame
from motes.core.geometry import Ellipse
from motes.core.types import Singles
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
    from scipy.fft import next_fast_len  # takes a third of a second to import

    shrink = min(1.0, COLUMNS / max(height, width))
    rows, columns = (max(round(side * shrink), 1) for side in (height, width))
    return int(next_fast_len(rows, real=True)), int(next_fast_len(columns, real=True))
