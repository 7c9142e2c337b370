"""Planes of values read between their points, and means over boxes from their sums."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from motes.kernels.compiling import kernel, unordered


@kernel
def look_up(
    plane: NDArray[np.float32],
    points: NDArray[np.float64],
    step: float,
    out: NDArray[np.float64],
) -> None:
    """Write a plane's bilinear value at points (N, 2) off its middle; 0 outside of it.

    `step` is from one value to the next.
    """
    for n in range(points.shape[0]):
        x, y = plane.shape[1] // 2 + points[n, 0] / step, plane.shape[0] // 2 + points[n, 1] / step
        out[n] = 0.0
        if 0.0 <= x <= plane.shape[1] - 1 and 0.0 <= y <= plane.shape[0] - 1:
            out[n] = _between(plane, y, x)


@kernel
def box_means(
    integral: NDArray[np.float64], boxes: NDArray[np.float64], out: NDArray[np.float64]
) -> None:
    """Write the mean over boxes (N, 4), x and y off the middle and half sides, from sums."""
    for n in range(boxes.shape[0]):
        out[n] = _box_mean(integral, boxes[n, 0], boxes[n, 1], boxes[n, 2], boxes[n, 3])


@kernel
def pool(
    integral: NDArray[np.float64],
    half: tuple[float, float],
    share: float,
    points: NDArray[np.float64],
    out: NDArray[np.float64],
) -> None:
    """Mix into values `out` a share of the mean over boxes around points (N, 2) off the middle."""
    for n in range(points.shape[0]):
        mean = _box_mean(integral, points[n, 0], points[n, 1], half[0], half[1])
        out[n] = (1 - share) * out[n] + share * mean


@unordered
def _box_mean(
    integral: NDArray[np.float64], x: float, y: float, across: float, down: float
) -> float:
    """Return the mean over a box; what reaches outside is left out; it has at least one sample."""
    rows, columns = integral.shape[0] - 1, integral.shape[1] - 1
    x, y = x + columns / 2, y + rows / 2
    left, top = min(max(x - across, 0.0), columns - 1.0), min(max(y - down, 0.0), rows - 1.0)
    right = min(max(x + across, left + 1.0), float(columns))
    bottom = min(max(y + down, top + 1.0), float(rows))
    total = _between(integral, bottom, right) - _between(integral, bottom, left)
    total += _between(integral, top, left) - _between(integral, top, right)
    return float(total / ((right - left) * (bottom - top)))


@unordered
def _between(plane: NDArray[Any], y: float, x: float) -> float:
    """Return a plane's bilinear value at row y and column x, both inside it."""
    i, j = min(int(y), plane.shape[0] - 2), min(int(x), plane.shape[1] - 2)
    down, across = y - i, x - j
    high = (1 - across) * plane[i, j] + across * plane[i, j + 1]
    low = (1 - across) * plane[i + 1, j] + across * plane[i + 1, j + 1]
    return float((1 - down) * high + down * low)
