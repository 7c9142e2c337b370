"""The fewest keyframes between which linear interpolation restores all rows."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from motes.core.types import Floats

KEYFRAME_ERROR = 1.0
"""Default of the largest deviation of interpolated coordinates, in pixels."""


def keyframes(
    frames: NDArray[np.int64], places: Floats, forced: NDArray[np.bool_], error: float
) -> NDArray[np.bool_]:
    """Return which rows are keyframes, shape (n,).

    From each keyframe, the next one is the last row up to which all rows in between stay within the
    error. The slopes that each row allows from the keyframe are an interval; a row can be the next
    keyframe while its slope lies in the intersection of those before it. After Tomek, Two
    algorithms for piecewise-linear continuous approximation of functions of one variable, 1974.
    Frames (n,) are in order, and places (n, k) are the coordinates in each. Rows that are `forced`
    (n,) are keyframes anyway, and so are the first and the last one. With an error of 0, each row
    is a keyframe.
    """
    chosen = forced | (error == 0)
    chosen[[0, -1]] = True
    start = 0
    while start < len(frames) - 1:
        start = _reach(frames, places, chosen, start, error)
        chosen[start] = True
    return chosen


def _reach(
    frames: NDArray[np.int64], places: Floats, forced: NDArray[np.bool_], start: int, error: float
) -> int:
    """Return the row of the next keyframe."""
    low, high = np.full(places.shape[1], -np.inf), np.full(places.shape[1], np.inf)
    best = start + 1
    for i in range(start + 1, len(frames)):
        elapsed = frames[i] - frames[start]
        step = places[i] - places[start]
        if ((low <= step / elapsed) & (step / elapsed <= high)).all():
            best = i
        low = np.maximum(low, (step - error) / elapsed)
        high = np.minimum(high, (step + error) / elapsed)
        if forced[i] or (low > high).any():
            break
    return best
