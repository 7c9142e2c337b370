"""Orientation by the structure tensor, and its histograms."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from motes.kernels.compiling import kernel
from motes.kernels.gradients import along_columns, along_rows, derivatives, turns
from motes.kernels.histograms import LANES, fill
from motes.kernels.sampling import PLANE, capacity, pixels_within


@kernel
def structure_tensor(
    pixels: NDArray[np.uint8],
    left: int,
    top: int,
    step: int,
    smooth: NDArray[np.float32],
    derivative: NDArray[np.float32],
    window: NDArray[np.float32],
    certainty: NDArray[np.float32],
    bins: NDArray[np.uint8],
    count: int,
) -> None:
    """Write certainty and orientation bin of each block of step x step pixels of a region.

    With J the structure tensor (Maggio et al., equation 3), z = J11 - J22 + 2i J12 has
    |z| = lambda_max - lambda_min, and twice the angle of the dominant eigenvector for its own: the
    certainty is |z| trace J (equation 4), the bin one of `count` of equal width over
    [-pi/2, pi/2). Filters are given by their taps at 0 … r.
    """
    height, width = certainty.shape
    outer = window.shape[0] - 1
    gx = np.empty((height + 2 * outer, width + 2 * outer), np.float32)
    gy = np.empty_like(gx)
    derivatives(pixels, left - outer * step, top - outer * step, step, smooth, derivative, gx, gy)
    narrow = np.empty((height + 2 * outer, width), np.float32)
    product = np.empty_like(gx)
    averages = np.empty((3, height, width), np.float32)
    for part in range(3):
        for y in range(gx.shape[0]):
            u, v, line = gx[y], gy[y], product[y]
            if part == 0:
                for x in range(line.shape[0]):
                    line[x] = u[x] * u[x] - v[x] * v[x]
            elif part == 1:
                for x in range(line.shape[0]):
                    line[x] = np.float32(2.0) * u[x] * v[x]
            else:
                for x in range(line.shape[0]):
                    line[x] = u[x] * u[x] + v[x] * v[x]
        along_rows(product, window, 1.0, narrow)
        along_columns(narrow, window, 1.0, averages[part])
    turn, wide = np.empty(width, np.float32), np.float32(count)
    for y in range(height):
        real, imaginary, trace = averages[0, y], averages[1, y], averages[2, y]
        line = certainty[y]
        for x in range(width):
            line[x] = np.sqrt(real[x] * real[x] + imaginary[x] * imaginary[x]) * trace[x]
        turns(imaginary, real, turn)
        for x in range(width):
            # Rounding may give a whole turn, which is none.
            number = np.int32(turn[x] * wide)
            bins[y, x] = np.uint8(number if number < count else 0)


@kernel
def histograms(
    certainty: NDArray[np.float32],
    bins: NDArray[np.uint8],
    left: int,
    top: int,
    ellipses: NDArray[np.float64],
    lattice: NDArray[np.float32],
    grid: tuple[int, int],
    profile: int,
    threshold: float,
    shifts: NDArray[np.float64],
    out: NDArray[np.float64],
) -> None:
    """Write each ellipse's normalized orientation histogram, zeros where it has no strong edge.

    Certainties above `threshold` are cumulated; the histogram is then turned back by `shifts`
    bins, whole or not, and smoothed by a triangle of two bins to either side, in one: the triangle
    is read at the shifted places. The plane begins at (left, top), in the units of the ellipses.
    """
    flat, numbers = certainty.reshape(-1), bins.reshape(-1)
    window = (left, top, certainty.shape[1], certainty.shape[0])
    room = capacity(window, ellipses, lattice)
    offsets, weights = np.empty(room, np.uint32), np.empty(room)
    count = out.shape[1]
    lanes = np.empty((LANES, count))
    for n in range(ellipses.shape[0]):
        points = pixels_within(
            window, ellipses[n], lattice, grid, profile, int(PLANE), offsets, weights
        )
        for i in range(points):
            value = flat[offsets[i]]
            # A branch that goes either way half of the time would take longer than all the rest.
            weights[i] *= value * np.float32(value > threshold)
        fill(offsets, weights, points, numbers, lanes)
        total = 0.0
        for u in range(count):
            total += lanes[0, u]
        shift = shifts[n] if total > 0.0 else 0.0
        whole = math.floor(shift)
        part = shift - whole
        scale = 0.25 / total if total > 0.0 else 0.0
        place = whole % count
        for u in range(count):
            before = (place if place > 0 else count) - 1
            after = place + 1 if place + 1 < count else 0
            last = after + 1 if after + 1 < count else 0
            # The triangle at distances 1 + part, part, 1 - part and 2 - part.
            out[n, u] = scale * (
                (1.0 - part) * lanes[0, before]
                + (2.0 - part) * lanes[0, place]
                + (1.0 + part) * lanes[0, after]
                + part * lanes[0, last]
            )
            place = after
