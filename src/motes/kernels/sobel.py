"""Edges by Sobel's operator, and histograms of their orientation."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from motes.kernels.compiling import kernel
from motes.kernels.gradients import derivatives_at, gray_values, turns
from motes.kernels.histograms import LANES, fill
from motes.kernels.sampling import ORIGIN, PLANE, capacity, pixels_within


@kernel
def _edge_bins(
    gx: NDArray[np.float32],
    gy: NDArray[np.float32],
    threshold: float,
    count: int,
    turn: NDArray[np.float32],
    bins: NDArray[np.uint8],
) -> None:
    """Write the bins of edges' orientations, `count` where one is no strong edge.

    Ng and Delp, equations 12 to 14. The `count` bins are of equal width over half a turn, the first
    one centered on -pi/2, a horizontal edge. Overwrites the derivatives; `turn` is room to work in.
    """
    least, wide, two = np.float32(threshold**4), np.float32(count), np.float32(2)
    for i in range(bins.shape[0]):  # twice the angle, opposite directions are one; strength squared
        real, imaginary = gx[i] * gx[i] - gy[i] * gy[i], two * gx[i] * gy[i]
        gx[i], gy[i] = real, imaginary
    turns(gy, gx, turn)
    for i in range(bins.shape[0]):
        number = np.int32(turn[i] * wide + np.float32(0.5))
        number = number if number < count else np.int32(0)  # half a turn on
        strong = gx[i] * gx[i] + gy[i] * gy[i] > least
        bins[i] = np.uint8(number if strong else count)


@kernel
def sobel(
    pixels: NDArray[np.uint8],
    left: int,
    top: int,
    threshold: float,
    count: int,
    bins: NDArray[np.uint8],
) -> None:
    """Write the bin of each pixel's edge, as `_edge_bins` does, by Sobel's operator.

    Ng and Delp, equations 10 and 11; past the border of the image its pixels repeat.
    """
    height, width = bins.shape
    gray = np.empty((height + 2, width + 2), np.float32)
    gray_values(pixels, left - 1, top - 1, gray)
    lines = np.empty((3, width), np.float32)
    gx, gy, turn = lines[0], lines[1], lines[2]
    two = np.float32(2)
    for y in range(height):
        above, here, below = gray[y], gray[y + 1], gray[y + 2]
        for x in range(width):
            gx[x] = (
                (above[x + 2] - above[x])
                + two * (here[x + 2] - here[x])
                + (below[x + 2] - below[x])
            )
            gy[x] = (
                (below[x] - above[x])
                + two * (below[x + 1] - above[x + 1])
                + (below[x + 2] - above[x + 2])
            )
        _edge_bins(gx, gy, threshold, count, turn, bins[y])


@kernel
def _histogram(
    slots: NDArray[np.uint8],
    keys: NDArray[np.uint32],
    weights: NDArray[np.float64],
    points: int,
    lanes: NDArray[np.float64],
    histogram: NDArray[np.float64],
) -> None:
    """Write the normalized histogram (count + 1,) of strong edges, as `histograms` has it."""
    fill(keys, weights, points, slots, lanes)
    count = histogram.shape[0] - 1
    total = 0.0
    for u in range(count):
        total += lanes[0, u]
    for u in range(count):
        histogram[u] = lanes[0, u] / total if total > 0.0 else 0.0
    histogram[count] = 1.0 if total == 0.0 and lanes[0, count] > 0.0 else 0.0


@kernel
def histograms(
    bins: NDArray[np.uint8],
    left: int,
    top: int,
    ellipses: NDArray[np.float64],
    lattice: NDArray[np.float32],
    grid: tuple[int, int],
    profile: int,
    out: NDArray[np.float64],
) -> None:
    """Write each ellipse's histogram of strong edges (Ng and Delp, equations 18 and 19).

    Its last place is 1 where there is none, else 0; all are 0 where no pixel is seen. The plane
    begins at (left, top).
    """
    flat = bins.reshape(-1)
    window = (left, top, bins.shape[1], bins.shape[0])
    room = capacity(window, ellipses, lattice)
    offsets, weights = np.empty(room, np.uint32), np.empty(room)
    lanes = np.empty((LANES, out.shape[1]))
    for n in range(ellipses.shape[0]):
        points = pixels_within(
            window, ellipses[n], lattice, grid, profile, int(PLANE), offsets, weights
        )
        _histogram(flat, offsets, weights, points, lanes, out[n])


@kernel
def histograms_at(
    pixels: NDArray[np.uint8],
    ellipses: NDArray[np.float64],
    lattice: NDArray[np.float32],
    profile: int,
    threshold: float,
    out: NDArray[np.float64],
) -> None:
    """Write the same histograms without a plane, by Sobel's operator at a lattice's points."""
    flat = pixels.reshape(-1)
    height, width = pixels.shape[0], pixels.shape[1]
    room, count = lattice.shape[1], out.shape[1] - 1
    places, weights = np.empty(room, np.uint32), np.empty(room)
    offsets, colors = np.empty(room, np.uint32), np.empty(room, np.uint32)
    work = np.empty((2, 3, room), np.int32)
    smooth, derivative = np.array([2, 1], np.float32), np.array([0, 1], np.float32)
    planes = np.empty((3, room), np.float32)
    gx, gy, turn = planes[0], planes[1], planes[2]
    order, bins = np.arange(room).astype(np.uint32), np.empty(room, np.uint8)
    lanes, window = np.empty((LANES, count + 1)), (*ORIGIN, width, height)
    for n in range(ellipses.shape[0]):
        points = pixels_within(
            window, ellipses[n], lattice, (1, 1), profile, int(PLANE), places, weights
        )
        if points > 0:
            derivatives_at(
                flat, places, width, height, smooth, derivative, work, offsets, colors, gx, gy
            )
            _edge_bins(gx, gy, threshold, count, turn, bins)
        _histogram(bins, order, weights, points, lanes, out[n])
