"""Which pixels of an ellipse are read, and how much each counts.

An ellipse's pixels are read at the points of `lattice`, (2, n) in the unit disk; where it is empty,
those are read whose row and column add up to a multiple of the first number of `grid`, and whose
row is a multiple of the second: 1, 1 is every pixel.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from motes.kernels.compiling import brief, kernel

EPANECHNIKOV, RADIAL, UNIFORM, GAUSSIAN = 0, 1, 2, 3
ORIGIN, PLANE, PICTURE = (0, 0), 1, 3
"""Where the window of a whole image begins; the channels of planes and pictures.

numba compiles a kernel anew for each number written out in a call of it: hence `*ORIGIN` there, and
`int` around the others.
"""


@kernel
def capacity(
    window: tuple[int, int, int, int],
    ellipses: NDArray[np.float64],
    lattice: NDArray[np.float32],
) -> int:
    """Return for how many points of an ellipse room is needed."""
    if lattice.shape[1] > 0:
        return int(lattice.shape[1])
    most = 0.0
    for n in range(ellipses.shape[0]):
        side = 2 * max(ellipses[n, 2], ellipses[n, 3]) + 2
        area = min(side, float(window[2])) * min(side, float(window[3]))
        most = area if area > most else most  # NaN is not
    return int(most) + 1


@kernel
def _bell(weights: NDArray[np.float64]) -> None:
    """Replace 1 - r² from 0 to 1 by exp(-r² / 2), as a series right to 1e-11: vector code."""
    for i in range(weights.shape[0]):
        t = 0.5 * (weights[i] - 1.0)
        tail = 1.0 + t / 6 * (1.0 + t / 7 * (1.0 + t / 8 * (1.0 + t / 9 * (1.0 + t / 10))))
        weights[i] = 1.0 + t * (1.0 + t / 2 * (1.0 + t / 3 * (1.0 + t / 4 * (1.0 + t / 5 * tail))))


@kernel
def pixels_within(
    window: tuple[int, int, int, int],
    ellipse: NDArray[np.float64],
    lattice: NDArray[np.float32],
    grid: tuple[int, int],
    profile: int,
    channels: int,
    offsets: NDArray[np.uint32],
    weights: NDArray[np.float64],
) -> int:
    """Write the pixels of an ellipse that are read, and their kernel weights; return how many.

    A pixel is its place in the flat `window` (left, top, width, height) of an image. Lattice points
    outside weigh nothing. Coordinates are the image's, whatever the window, down to rounding.
    """
    left, top, width, height = window
    x, y, a, b, theta = ellipse[0], ellipse[1], ellipse[2], ellipse[3], ellipse[4]
    cos, sin = math.cos(theta), math.sin(theta)
    across = math.sqrt(a * a * cos * cos + b * b * sin * sin)
    down = math.sqrt(a * a * sin * sin + b * b * cos * cos)
    # 1 - r² with r over the bandwidth sqrt(a² + b²), or over the ellipse itself; or 1 everywhere.
    # A bell is made of the second.
    uu, vv = (0.0, 0.0) if profile == UNIFORM else (1.0, 1.0)
    if profile == RADIAL:
        uu, vv = a * a / (a * a + b * b), b * b / (a * a + b * b)
    right, bottom = left + width, top + height
    if not math.isfinite(x + y + across + down):
        return 0
    if x + across < left - 1 or y + down < top - 1 or x - across > right or y - down > bottom:
        return 0
    if lattice.shape[1] > 0:
        ax, ay = np.float32(a * cos), np.float32(a * sin)
        bx, by = np.float32(-b * sin), np.float32(b * cos)
        # Places are counted from the ellipse's own corner, whole numbers taken off: so they are
        # positive and small, and single precision is right to 1e-4 pixels in an ellipse of 1,000.
        corner_x, corner_y = math.floor(x + 0.5 - across), math.floor(y + 0.5 - down)
        x0, y0 = np.float32(x + 0.5 - corner_x), np.float32(y + 0.5 - corner_y)
        column, row = corner_x - left, corner_y - top
        corner = np.int32(channels * (row * width + column))
        pixel, line = np.int32(channels), np.int32(channels * width)
        us, vs, one = lattice[0], lattice[1], np.float32(1)
        du, dv = np.float32(uu), np.float32(vv)
        for i in range(us.shape[0]):  # without branches, so that it becomes vector code
            u, v = us[i], vs[i]
            px, py = np.int32(x0 + u * ax + v * bx), np.int32(y0 + u * ay + v * by)
            place = np.int32(py * line) + np.int32(px * pixel)
            offsets[i] = np.int32(corner + np.int32(place))
            weights[i] = one - (u * u * du + v * v * dv)
        if profile == GAUSSIAN:
            _bell(weights)
        if (
            x - across < left or y - down < top or x + across + 1 >= right or y + down + 1 >= bottom
        ):  # fmt: skip
            for i in range(us.shape[0]):
                u, v = us[i], vs[i]
                at_x = column + int(np.int32(x0 + u * ax + v * bx))
                at_y = row + int(np.int32(y0 + u * ay + v * by))
                if at_x < 0 or at_y < 0 or at_x >= width or at_y >= height:
                    offsets[i], weights[i] = np.uint32(0), 0.0
                else:  # again: an absurdly large ellipse may have overflowed above, and elsewhere
                    offsets[i] = np.uint32(channels * (at_y * width + at_x))
        return int(lattice.shape[1])
    first = max(left, math.ceil(x - across))
    last = min(left + width - 1, math.floor(x + across))
    above = max(top, math.ceil(y - down))
    below = min(top + height - 1, math.floor(y + down))
    across, down = grid
    count = 0
    for row in range(above + -above % down, below + 1, down):
        for column in range(first + -(row + first) % across, last + 1, across):
            u = ((column - x) * cos + (row - y) * sin) / a
            v = ((row - y) * cos - (column - x) * sin) / b
            if u * u + v * v < 1.0:
                offsets[count] = channels * ((row - top) * width + column - left)
                weights[count] = 1.0 - (u * u * uu + v * v * vv)
                count += 1
    if profile == GAUSSIAN:
        _bell(weights[:count])
    return count


@kernel
def colors_at(
    flat: NDArray[np.uint8], offsets: NDArray[np.uint32], count: int, colors: NDArray[np.uint32]
) -> None:
    """Write the colors at places in the flat image, each as r + 256 g + 65536 b."""
    for i in range(count):
        offset = offsets[i]
        colors[i] = (
            np.uint32(flat[offset])
            | (np.uint32(flat[offset + np.uint32(1)]) << np.uint32(8))
            | (np.uint32(flat[offset + np.uint32(2)]) << np.uint32(16))
        )


@kernel
def values_within(
    plane: NDArray[np.float32],
    left: int,
    top: int,
    ellipse: NDArray[np.float64],
    lattice: NDArray[np.float32],
    grid: tuple[int, int],
) -> NDArray[np.float32]:
    """Return the values of a plane (H, W) at the points of an ellipse, without those outside.

    The plane begins at (left, top), in the units of the ellipse.
    """
    window = (left, top, plane.shape[1], plane.shape[0])
    flat = plane.reshape(-1)
    room = capacity(window, ellipse.reshape(1, 5), lattice)
    offsets, weights = np.empty(room, np.uint32), np.empty(room)
    points = pixels_within(
        window, ellipse, lattice, grid, int(UNIFORM), int(PLANE), offsets, weights
    )
    values = np.empty(points, np.float32)
    count = 0
    for i in range(points):
        if weights[i] > 0.0:
            values[count] = flat[offsets[i]]
            count += 1
    return values[:count]


@brief
def bounds(ellipses: NDArray[np.float64]) -> tuple[float, float, float, float]:
    """Return the left, top, right and bottom end of what ellipses cover.

    Those with NaN or infinity cover nothing; the left end of nothing is right of its right end.
    """
    left = top = np.inf
    right = bottom = -np.inf
    for n in range(ellipses.shape[0]):
        x, y, a, b = ellipses[n, 0], ellipses[n, 1], ellipses[n, 2], ellipses[n, 3]
        cos, sin = math.cos(ellipses[n, 4]), math.sin(ellipses[n, 4])
        across = math.sqrt(a * a * cos * cos + b * b * sin * sin)
        down = math.sqrt(a * a * sin * sin + b * b * cos * cos)
        if not math.isfinite(x + y + across + down):
            continue
        left, top = min(left, x - across), min(top, y - down)
        right, bottom = max(right, x + across), max(bottom, y + down)
    return left, top, right, bottom
