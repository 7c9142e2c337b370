"""Histograms of color, their distance, and mean shift on them.

Color spaces are numbered (`RGB`, `HSV`, `HSV_V`); a pixel's bin is (i0 * n1 + i1) * n2 + i2 for
bins n0 x n1 x n2, equally wide in each channel, or in `HSV_V` i0 * n1 + i1 of n0 x n1 for a pixel
with color and n0 * n1 + i2 for one without. `slots` maps each of these bins to a place in a
histogram that holds only the bins wanted, its last place taking all others.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from motes.kernels.compiling import kernel
from motes.kernels.histograms import LANES, coefficient, fill
from motes.kernels.sampling import EPANECHNIKOV, ORIGIN, PICTURE, capacity, colors_at, pixels_within

RGB, HSV, HSV_V = 0, 1, 2


@kernel
def to_bins(colors: NDArray[np.uint32], count: int, space: int, n0: int, n1: int, n2: int) -> None:
    """Replace colors, as `colors_at` writes them, by their bins; without branches: vector code.

    In HSV, channels run from 0 to 1, gray has hue 0. Hue and saturation are fractions of small
    integers, whose quotient in single precision is never rounded onto or over the next integer:
    bins are exact. A pixel has color in `HSV_V` where saturation is above 0.1 and value above 0.2.
    """
    m0, m1, m2 = np.uint32(n0), np.uint32(n1), np.uint32(n2)
    byte, eight = np.uint32(255), np.uint32(8)
    if space == RGB:
        for i in range(count):
            color = colors[i]
            i0 = ((color & byte) * m0) >> eight
            i1 = (((color >> eight) & byte) * m1) >> eight
            colors[i] = (i0 * m1 + i1) * m2 + (((color >> np.uint32(16)) * m2) >> eight)
        return
    f0, f1, six = np.float32(n0), np.float32(n1), np.float32(6)
    apart, pairs = space == HSV_V, m0 * m1
    for i in range(count):
        color = colors[i]
        r = np.float32(np.int32(color & byte))
        g = np.float32(np.int32((color >> eight) & byte))
        b = np.float32(np.int32(color >> np.uint32(16)))
        high = max(r, max(g, b))
        spread = high - min(r, min(g, b))
        # Six times the hue, times the spread.
        hue = np.float32(4) * spread + r - g
        hue = np.float32(2) * spread + b - r if high == g else hue
        hue = g - b if high == r else hue
        hue = hue + six * spread if hue < np.float32(0) else hue
        gray = spread == np.float32(0)
        i0 = np.uint32(np.int32(hue * f0 / (np.float32(1) if gray else six * spread)))
        i1 = np.uint32(np.int32(spread * f1 / (np.float32(1) if gray else high)))
        i1 = min(i1, m1 - np.uint32(1))
        i2 = (np.uint32(np.int32(high)) * m2) >> eight
        pair = i0 * m1 + i1
        if apart:
            colored = (np.float32(10) * spread > high) & (high > np.float32(51))
            colors[i] = pair if colored else pairs + i2
        else:
            colors[i] = pair * m2 + i2


@kernel
def histograms(
    pixels: NDArray[np.uint8],
    ellipses: NDArray[np.float64],
    lattice: NDArray[np.float32],
    grid: tuple[int, int],
    profile: int,
    slots: NDArray[np.uint32],
    space: int,
    n0: int,
    n1: int,
    n2: int,
    out: NDArray[np.float64],
) -> None:
    """Write each ellipse's normalized histogram (equation 3), zeros where it sees no pixel."""
    flat = pixels.reshape(-1)
    window = (*ORIGIN, pixels.shape[1], pixels.shape[0])
    room = capacity(window, ellipses, lattice)
    offsets, colors = np.empty(room, np.uint32), np.empty(room, np.uint32)
    weights = np.empty(room)
    lanes = np.empty((LANES, out.shape[1]))
    for n in range(ellipses.shape[0]):
        count = pixels_within(
            window, ellipses[n], lattice, grid, profile, int(PICTURE), offsets, weights
        )
        colors_at(flat, offsets, count, colors)
        to_bins(colors, count, space, n0, n1, n2)
        fill(colors, weights, count, slots, lanes)
        total = 0.0
        for slot in range(lanes.shape[1]):
            total += lanes[0, slot]
        for slot in range(lanes.shape[1]):
            out[n, slot] = lanes[0, slot] / total if total > 0.0 else 0.0


@kernel
def distances(
    pixels: NDArray[np.uint8],
    ellipses: NDArray[np.float64],
    lattice: NDArray[np.float32],
    grid: tuple[int, int],
    profile: int,
    slots: NDArray[np.uint32],
    roots: NDArray[np.float64],
    space: int,
    n0: int,
    n1: int,
    n2: int,
    out: NDArray[np.float64],
) -> None:
    """Write each ellipse's Bhattacharyya distance to a target model (equations 6 and 7).

    `roots` holds the square roots of the model's occupied bins, which alone can add to the sum.
    An ellipse that sees no pixel is at distance 1.
    """
    flat = pixels.reshape(-1)
    window = (*ORIGIN, pixels.shape[1], pixels.shape[0])
    room = capacity(window, ellipses, lattice)
    offsets, colors = np.empty(room, np.uint32), np.empty(room, np.uint32)
    weights = np.empty(room)
    lanes = np.empty((LANES, roots.shape[0] + 1))
    for n in range(ellipses.shape[0]):
        count = pixels_within(
            window, ellipses[n], lattice, grid, profile, int(PICTURE), offsets, weights
        )
        colors_at(flat, offsets, count, colors)
        to_bins(colors, count, space, n0, n1, n2)
        fill(colors, weights, count, slots, lanes)
        rho = coefficient(roots, lanes[0])
        out[n] = math.sqrt(max(0.0, 1.0 - rho))


@kernel
def mean_shift(
    pixels: NDArray[np.uint8],
    ellipse: NDArray[np.float64],
    lattice: NDArray[np.float32],
    grid: tuple[int, int],
    slots: NDArray[np.uint32],
    ratios: NDArray[np.float64],
    space: int,
    n0: int,
    n1: int,
    n2: int,
    center: NDArray[np.float64],
) -> None:
    """Write the mean (x, y) of an ellipse's pixels, each weighted by its bin's entry in `ratios`.

    Leaves `center` as it is where no pixel has any weight.
    """
    flat = pixels.reshape(-1)
    window = (*ORIGIN, pixels.shape[1], pixels.shape[0])
    room = capacity(window, ellipse.reshape(1, 5), lattice)
    offsets, colors = np.empty(room, np.uint32), np.empty(room, np.uint32)
    weights = np.empty(room)
    count = pixels_within(
        window, ellipse, lattice, grid, int(EPANECHNIKOV), int(PICTURE), offsets, weights
    )
    colors_at(flat, offsets, count, colors)
    to_bins(colors, count, space, n0, n1, n2)
    total, sum_x, sum_y = 0.0, 0.0, 0.0
    for i in range(count):
        if weights[i] > 0.0:
            weight = ratios[slots[colors[i]]]
            row, column = divmod(np.int64(offsets[i]) // 3, pixels.shape[1])
            total += weight
            sum_x += weight * column
            sum_y += weight * row
    if total > 0.0:
        center[0] = sum_x / total
        center[1] = sum_y / total
