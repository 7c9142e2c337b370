"""Histograms of oriented gradients, by cells of the box around an ellipse."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from motes.kernels.compiling import kernel
from motes.kernels.gradients import derivatives, derivatives_at, turns
from motes.kernels.histograms import LANES, fill
from motes.kernels.sampling import ORIGIN, PLANE, capacity, pixels_within

BAND = 32


@kernel
def _directions(
    gx: NDArray[np.float32],
    gy: NDArray[np.float32],
    count: int,
    strength: NDArray[np.float32],
    bins: NDArray[np.uint8],
) -> None:
    """Write the strength of gradients and the bins of their directions.

    The `count` bins are of equal width over a whole turn, the first one centered on the -x axis.
    """
    turn = strength  # which is written over in the end
    turns(gy, gx, turn)
    wide = np.float32(count)
    for i in range(bins.shape[0]):
        number = np.int32(turn[i] * wide + np.float32(0.5))
        bins[i] = np.uint8(number if number < count else np.int32(0))  # a whole turn is none
        strength[i] = np.sqrt(gx[i] * gx[i] + gy[i] * gy[i])


@kernel
def gradients(
    pixels: NDArray[np.uint8],
    left: int,
    top: int,
    smooth: NDArray[np.float32],
    derivative: NDArray[np.float32],
    strength: NDArray[np.float32],
    bins: NDArray[np.uint8],
    count: int,
) -> None:
    """Write strength and direction of the gradient at each pixel of a region, as `_directions`."""
    height, width = strength.shape
    for above in range(0, height, BAND):  # which stay in the processor's cache
        rows = min(BAND, height - above)
        gx, gy = np.empty((rows, width), np.float32), np.empty((rows, width), np.float32)
        derivatives(pixels, left, top + above, 1, smooth, derivative, gx, gy)
        for y in range(rows):
            _directions(gx[y], gy[y], count, strength[above + y], bins[above + y])


@kernel
def _cells(
    window: tuple[int, int, int, int],
    ellipse: NDArray[np.float64],
    lattice: NDArray[np.float32],
    side: int,
    offsets: NDArray[np.uint32],
    count: int,
    cells: NDArray[np.uint32],
) -> None:
    """Write in which of side x side cells of the box around an ellipse its points lie.

    The box is that of the ellipse's own axes, and turns with it. Points are as `pixels_within`
    writes them, for one channel.
    """
    half, last = 0.5 * side, np.int32(side - 1)
    if lattice.shape[1] > 0:
        us, vs = lattice[0], lattice[1]
        for i in range(count):
            column, row = np.int32((us[i] + 1.0) * half), np.int32((vs[i] + 1.0) * half)
            cells[i] = np.uint32(min(row, last) * side + min(column, last))
        return
    left, top, width, _ = window
    cos, sin = math.cos(ellipse[4]), math.sin(ellipse[4])
    for i in range(count):
        line, place = divmod(np.int64(offsets[i]), width)
        x, y = left + place - ellipse[0], top + line - ellipse[1]
        u, v = (x * cos + y * sin) / ellipse[2], (y * cos - x * sin) / ellipse[3]
        column, row = np.int32((u + 1.0) * half), np.int32((v + 1.0) * half)
        cells[i] = np.uint32(min(row, last) * side + min(column, last))


@kernel
def _histogram(
    cells: NDArray[np.uint32],
    bins: NDArray[np.uint8],
    strength: NDArray[np.float32],
    weights: NDArray[np.float64],
    points: int,
    slots: NDArray[np.uint8],
    count: int,
    turned: bool,
    lanes: NDArray[np.float64],
    histogram: NDArray[np.float64],
) -> None:
    """Write the normalized histogram of gradients by cell and direction.

    If `turned`, each cell's is turned by whole bins, all alike, so that the direction that is
    strongest over all cells comes first. `slots` are 0, 1, 2 …; `cells` and `weights` are
    overwritten, and `lanes` is room to work in.
    """
    for i in range(points):
        cells[i] = cells[i] * np.uint32(count) + np.uint32(bins[i])
        weights[i] *= strength[i]
    fill(cells, weights, points, slots, lanes)
    total, most, first = 0.0, 0.0, 0
    for u in range(count):
        direction = 0.0
        for cell in range(0, histogram.shape[0], count):
            direction += lanes[0, cell + u]
        total += direction
        if turned and direction > most:
            most, first = direction, u
    for cell in range(0, histogram.shape[0], count):
        for u in range(count):
            value = lanes[0, cell + (u + first) % count]
            histogram[cell + u] = value / total if total > 0.0 else 0.0


@kernel
def histograms(
    strength: NDArray[np.float32],
    bins: NDArray[np.uint8],
    left: int,
    top: int,
    ellipses: NDArray[np.float64],
    lattice: NDArray[np.float32],
    grid: tuple[int, int],
    profile: int,
    side: int,
    turned: bool,
    out: NDArray[np.float64],
) -> None:
    """Write each ellipse's histogram of gradients, as `_histogram` does; zeros where there is none.

    It has side x side cells. The plane begins at (left, top).
    """
    values, numbers = strength.reshape(-1), bins.reshape(-1)
    window = (left, top, bins.shape[1], bins.shape[0])
    room, size = capacity(window, ellipses, lattice), out.shape[1]
    offsets, weights = np.empty(room, np.uint32), np.empty(room)
    cells, found = np.empty(room, np.uint32), np.empty(room, np.float32)
    at, count = np.empty(room, np.uint8), size // (side * side)
    slots, lanes = np.arange(size).astype(np.uint8), np.empty((LANES, size))
    for n in range(ellipses.shape[0]):
        points = pixels_within(
            window, ellipses[n], lattice, grid, profile, int(PLANE), offsets, weights
        )
        for i in range(points):
            found[i], at[i] = values[offsets[i]], numbers[offsets[i]]
        _cells(window, ellipses[n], lattice, side, offsets, points, cells)
        _histogram(cells, at, found, weights, points, slots, count, turned, lanes, out[n])


@kernel
def histograms_at(
    pixels: NDArray[np.uint8],
    ellipses: NDArray[np.float64],
    lattice: NDArray[np.float32],
    profile: int,
    side: int,
    turned: bool,
    smooth: NDArray[np.float32],
    derivative: NDArray[np.float32],
    out: NDArray[np.float64],
) -> None:
    """Write the same histograms without a plane, by gradients at a lattice's points."""
    flat = pixels.reshape(-1)
    window = (*ORIGIN, pixels.shape[1], pixels.shape[0])
    room, size = lattice.shape[1], out.shape[1]
    count = size // (side * side)
    places, weights = np.empty(room, np.uint32), np.empty(room)
    offsets, colors = np.empty(room, np.uint32), np.empty(room, np.uint32)
    work = np.empty((2, 2 * smooth.shape[0] - 1, room), np.int32)
    planes = np.empty((3, room), np.float32)
    gx, gy, strength = planes[0], planes[1], planes[2]
    cells, bins = np.empty(room, np.uint32), np.empty(room, np.uint8)
    slots, lanes = np.arange(size).astype(np.uint8), np.empty((LANES, size))
    for n in range(ellipses.shape[0]):
        points = pixels_within(
            window, ellipses[n], lattice, (1, 1), profile, int(PLANE), places, weights
        )
        if points > 0:
            derivatives_at(
                flat, places, pixels.shape[1], pixels.shape[0], smooth, derivative, work,
                offsets, colors, gx, gy,
            )  # fmt: skip
            _directions(gx, gy, count, strength, bins)
        _cells(window, ellipses[n], lattice, side, places, points, cells)
        _histogram(cells, bins, strength, weights, points, slots, count, turned, lanes, out[n])
