"""Every compiled loop, and nothing else; imports numpy and numba only.

Kernels release the GIL, allocate nothing inside loops and know no Python objects. An ellipse is a
row x, y, a, b, theta. Color spaces are numbered (`RGB`, `HSV`); a pixel's bin is
(i0 * n1 + i1) * n2 + i2 for bins n0 x n1 x n2, equally wide in each channel. `slots` maps each
of these bins to a place in a histogram that holds only the bins wanted, its last place taking
all others.
"""

from __future__ import annotations

import math
import os
from collections.abc import Callable
from pathlib import Path
from typing import Any, TypeVar, cast

import numpy as np
from numpy.typing import NDArray

F = TypeVar("F", bound=Callable[..., object])


def _use_cache() -> bool:
    """Point numba at a writable cache folder; False where there is none (a read-only system)."""
    if "NUMBA_CACHE_DIR" not in os.environ:
        try:
            home = Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache")
            folder = home / "motes" / "numba"
            folder.mkdir(parents=True, exist_ok=True)
        except (OSError, RuntimeError):
            return False
        if not os.access(folder, os.W_OK):
            return False
        os.environ["NUMBA_CACHE_DIR"] = str(folder)
    return True


CACHED = _use_cache()
"""Whether compiled kernels are kept on disk for the next run."""

import numba  # noqa: E402  (reads NUMBA_CACHE_DIR when imported)


def _kernel(function: F) -> F:
    """Compile a loop on first use, without the GIL, kept on disk where possible."""
    return cast(F, numba.njit(nogil=True, cache=CACHED, error_model="numpy")(function))


RGB, HSV = 0, 1
LANES = 4


@_kernel
def _channel_table(space: int, n0: int, n1: int, n2: int) -> NDArray[np.uint32]:
    """Return what each channel's value adds to an RGB color's bin, (3, 256); HSV needs none."""
    table = np.zeros((3, 256), np.uint32)
    if space == RGB:
        for value in range(256):
            table[0, value] = ((value * n0) >> 8) * n1 * n2
            table[1, value] = ((value * n1) >> 8) * n2
            table[2, value] = (value * n2) >> 8
    return table


@_kernel
def _hsv_bin(r: Any, g: Any, b: Any, n0: int, n1: int, n2: int) -> Any:
    """Return the bin of an RGB color in HSV; channels run from 0 to 1, gray has hue 0."""
    high = max(r, g, b)
    spread = high - min(r, g, b)
    if spread == 0:
        return (high * n2) >> 8
    # Six times the hue, times the spread: an integer, so that bins are exact.
    if high == r:
        hue = g - b
        if hue < 0:
            hue += 6 * spread
    elif high == g:
        hue = 2 * spread + b - r
    else:
        hue = 4 * spread + r - g
    i0 = (hue * n0) // (6 * spread)
    i1 = min((spread * n1) // high, n1 - 1)
    return (i0 * n1 + i1) * n2 + ((high * n2) >> 8)


@_kernel
def _capacity(
    shape: tuple[int, int, int], ellipses: NDArray[np.float64], lattice: NDArray[np.float64]
) -> int:
    """Return for how many points of an ellipse room is needed."""
    if lattice.shape[1] > 0:
        return int(lattice.shape[1])
    most = 0.0
    for n in range(ellipses.shape[0]):
        side = 2 * max(ellipses[n, 2], ellipses[n, 3]) + 2
        most = max(most, min(side, float(shape[0])) * min(side, float(shape[1])))
    return int(most) + 1


@_kernel
def _points(
    shape: tuple[int, int, int],
    ellipse: NDArray[np.float64],
    lattice: NDArray[np.float64],
    radial: bool,
    offsets: NDArray[np.uint32],
    weights: NDArray[np.float64],
) -> int:
    """Write the pixels of an ellipse that are read, and their kernel weights; return how many.

    A pixel is its place in the flat image. Lattice points outside the image weigh nothing.
    """
    height, width = shape[0], shape[1]
    x, y, a, b, theta = ellipse[0], ellipse[1], ellipse[2], ellipse[3], ellipse[4]
    cos, sin = math.cos(theta), math.sin(theta)
    # Equation 2 with the bandwidth sqrt(a² + b²), or with the ellipse itself as its unit.
    uu = a * a / (a * a + b * b) if radial else 1.0
    vv = b * b / (a * a + b * b) if radial else 1.0
    if lattice.shape[1] > 0:
        ax, ay, bx, by = a * cos, a * sin, -b * sin, b * cos
        left, top = x + 0.5, y + 0.5
        for i in range(lattice.shape[1]):  # branchless, so that it becomes vector code
            u, v = lattice[0, i], lattice[1, i]
            px = left + u * ax + v * bx
            py = top + u * ay + v * by
            inside = (px >= 0.0) & (py >= 0.0) & (px < width) & (py < height)
            place = np.int32(py) * np.int32(width) + np.int32(px)
            offsets[i] = np.uint32(3 * place) if inside else np.uint32(0)
            weights[i] = 1.0 - (u * u * uu + v * v * vv) if inside else 0.0
        return int(lattice.shape[1])
    half_width, half_height = math.hypot(a * cos, b * sin), math.hypot(a * sin, b * cos)
    first, last = max(0, math.ceil(x - half_width)), min(width - 1, math.floor(x + half_width))
    count = 0
    for row in range(
        max(0, math.ceil(y - half_height)), min(height - 1, math.floor(y + half_height)) + 1
    ):
        for column in range(first, last + 1):
            u = ((column - x) * cos + (row - y) * sin) / a
            v = ((row - y) * cos - (column - x) * sin) / b
            if u * u + v * v < 1.0:
                offsets[count] = 3 * (row * width + column)
                weights[count] = 1.0 - (u * u * uu + v * v * vv)
                count += 1
    return count


@_kernel
def _slot(
    flat: NDArray[np.uint8],
    offset: Any,
    slots: NDArray[np.uint32],
    table: NDArray[np.uint32],
    space: int,
    n0: int,
    n1: int,
    n2: int,
) -> Any:
    """Return the slot of the color at a place in the flat image."""
    r, g, b = flat[offset], flat[offset + np.uint32(1)], flat[offset + np.uint32(2)]
    if space == RGB:
        return slots[table[0, r] + table[1, g] + table[2, b]]
    return slots[_hsv_bin(np.int64(r), np.int64(g), np.int64(b), n0, n1, n2)]


@_kernel
def _fill(
    flat: NDArray[np.uint8],
    offsets: NDArray[np.uint32],
    weights: NDArray[np.float64],
    count: int,
    slots: NDArray[np.uint32],
    table: NDArray[np.uint32],
    space: int,
    n0: int,
    n1: int,
    n2: int,
    lanes: NDArray[np.float64],
) -> None:
    """Add the weights of `count` pixels to a histogram, which is afterwards in lane 0.

    Neighbors often share a bin; adding them in turn to separate lanes keeps one addition from
    waiting for the one before.
    """
    lanes[:] = 0.0
    for i in range(count):
        slot = _slot(flat, offsets[i], slots, table, space, n0, n1, n2)
        lanes[np.uint32(i) % np.uint32(LANES), slot] += weights[i]
    for slot in range(lanes.shape[1]):
        lanes[0, slot] += lanes[1, slot] + lanes[2, slot] + lanes[3, slot]


@_kernel
def color_histograms(
    pixels: NDArray[np.uint8],
    ellipses: NDArray[np.float64],
    lattice: NDArray[np.float64],
    radial: bool,
    slots: NDArray[np.uint32],
    space: int,
    n0: int,
    n1: int,
    n2: int,
    histograms: NDArray[np.float64],
) -> None:
    """Write each ellipse's normalized histogram (equation 3), zeros where it sees no pixel.

    An empty `lattice` means every pixel.
    """
    flat = pixels.reshape(-1)
    table = _channel_table(space, n0, n1, n2)
    room = _capacity(pixels.shape, ellipses, lattice)
    offsets, weights = np.empty(room, np.uint32), np.empty(room)
    lanes = np.empty((LANES, histograms.shape[1]))
    for n in range(ellipses.shape[0]):
        count = _points(pixels.shape, ellipses[n], lattice, radial, offsets, weights)
        _fill(flat, offsets, weights, count, slots, table, space, n0, n1, n2, lanes)
        total = lanes[0].sum()
        for slot in range(lanes.shape[1]):
            histograms[n, slot] = lanes[0, slot] / total if total > 0.0 else 0.0


@_kernel
def color_distances(
    pixels: NDArray[np.uint8],
    ellipses: NDArray[np.float64],
    lattice: NDArray[np.float64],
    radial: bool,
    slots: NDArray[np.uint32],
    roots: NDArray[np.float64],
    space: int,
    n0: int,
    n1: int,
    n2: int,
    distances: NDArray[np.float64],
) -> None:
    """Write each ellipse's Bhattacharyya distance to a target model (equations 6 and 7).

    `roots` holds the square roots of the model's occupied bins, which alone can add to the sum.
    An ellipse that sees no pixel is at distance 1. An empty `lattice` means every pixel.
    """
    flat = pixels.reshape(-1)
    table = _channel_table(space, n0, n1, n2)
    room = _capacity(pixels.shape, ellipses, lattice)
    offsets, weights = np.empty(room, np.uint32), np.empty(room)
    occupied = roots.shape[0]
    lanes = np.empty((LANES, occupied + 1))
    for n in range(ellipses.shape[0]):
        count = _points(pixels.shape, ellipses[n], lattice, radial, offsets, weights)
        _fill(flat, offsets, weights, count, slots, table, space, n0, n1, n2, lanes)
        rho, total = 0.0, lanes[0, occupied]
        for u in range(occupied):
            rho += roots[u] * math.sqrt(lanes[0, u])
            total += lanes[0, u]
        if total > 0.0:
            rho /= math.sqrt(total)
        distances[n] = math.sqrt(max(0.0, 1.0 - rho))


@_kernel
def moments(
    ellipses: NDArray[np.float64],
    weights: NDArray[np.float64],
    mean: NDArray[np.float64],
    covariance: NDArray[np.float64],
) -> None:
    """Write the weighted mean (5,) and covariance (5, 5) of ellipses, angles modulo pi."""
    mean[:] = 0.0
    covariance[:] = 0.0
    sin, cos = 0.0, 0.0
    for n in range(ellipses.shape[0]):
        for i in range(4):
            mean[i] += weights[n] * ellipses[n, i]
        sin += weights[n] * math.sin(2 * ellipses[n, 4])
        cos += weights[n] * math.cos(2 * ellipses[n, 4])
    mean[4] = math.atan2(sin, cos) / 2
    off = np.empty(5)
    for n in range(ellipses.shape[0]):
        for i in range(5):
            off[i] = ellipses[n, i] - mean[i]
        off[4] -= math.pi * np.rint(off[4] / math.pi)
        for i in range(5):
            for j in range(5):
                covariance[i, j] += weights[n] * off[i] * off[j]


@_kernel
def mean_shift(
    pixels: NDArray[np.uint8],
    ellipse: NDArray[np.float64],
    lattice: NDArray[np.float64],
    slots: NDArray[np.uint32],
    ratios: NDArray[np.float64],
    space: int,
    n0: int,
    n1: int,
    n2: int,
    center: NDArray[np.float64],
) -> None:
    """Write the mean (x, y) of an ellipse's pixels, each weighted by its bin's entry in `ratios`.

    Leaves `center` as it is where no pixel has any weight. An empty `lattice` means every pixel.
    """
    flat = pixels.reshape(-1)
    table = _channel_table(space, n0, n1, n2)
    room = _capacity(pixels.shape, ellipse.reshape(1, 5), lattice)
    offsets, weights = np.empty(room, np.uint32), np.empty(room)
    count = _points(pixels.shape, ellipse, lattice, False, offsets, weights)
    total, sum_x, sum_y = 0.0, 0.0, 0.0
    for i in range(count):
        if weights[i] > 0.0:
            weight = ratios[_slot(flat, offsets[i], slots, table, space, n0, n1, n2)]
            row, column = divmod(np.int64(offsets[i]) // 3, pixels.shape[1])
            total += weight
            sum_x += weight * column
            sum_y += weight * row
    if total > 0.0:
        center[0] = sum_x / total
        center[1] = sum_y / total


def cache_folder() -> Path | None:
    """Return the folder where compiled kernels are kept, None where there is none."""
    folder = color_distances.stats.cache_path  # type: ignore[attr-defined]
    return Path(folder) if CACHED and folder else None
