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


@_kernel
def color_bin(r: Any, g: Any, b: Any, space: int, n0: int, n1: int, n2: int) -> Any:
    """Return the bin of a color; hue, saturation and value run from 0 to 1, gray has hue 0."""
    if space == RGB:
        return (((r * n0) >> 8) * n1 + ((g * n1) >> 8)) * n2 + ((b * n2) >> 8)
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
def _fill_lattice(
    pixels: NDArray[np.uint8],
    ellipse: NDArray[np.float64],
    lattice: NDArray[np.float64],
    isotropic: bool,
    slots: NDArray[np.int32],
    space: int,
    n0: int,
    n1: int,
    n2: int,
    histogram: NDArray[np.float64],
) -> float:
    """Add the kernel weights of an ellipse's lattice points to a histogram; return their sum."""
    height, width = pixels.shape[0], pixels.shape[1]
    x, y, a, b, theta = ellipse[0], ellipse[1], ellipse[2], ellipse[3], ellipse[4]
    cos, sin = math.cos(theta), math.sin(theta)
    ax, ay, bx, by = a * cos, a * sin, -b * sin, b * cos
    # Equation 2 with the bandwidth sqrt(a² + b²), or with the ellipse itself as its unit.
    uu = a * a / (a * a + b * b) if isotropic else 1.0
    vv = b * b / (a * a + b * b) if isotropic else 1.0
    x += 0.5
    y += 0.5
    total = 0.0
    for i in range(lattice.shape[0]):
        u, v = lattice[i, 0], lattice[i, 1]
        px = x + u * ax + v * bx
        py = y + u * ay + v * by
        if px >= 0.0 and py >= 0.0 and px < width and py < height:
            column, row = int(px), int(py)
            slot = slots[
                color_bin(
                    np.int64(pixels[row, column, 0]),
                    np.int64(pixels[row, column, 1]),
                    np.int64(pixels[row, column, 2]),
                    space, n0, n1, n2,
                )
            ]  # fmt: skip
            weight = 1.0 - (u * u * uu + v * v * vv)
            histogram[slot] += weight
            total += weight
    return total


@_kernel
def _fill_pixels(
    pixels: NDArray[np.uint8],
    ellipse: NDArray[np.float64],
    isotropic: bool,
    slots: NDArray[np.int32],
    space: int,
    n0: int,
    n1: int,
    n2: int,
    histogram: NDArray[np.float64],
) -> float:
    """Add the kernel weights of every pixel inside an ellipse to a histogram; return their sum."""
    height, width = pixels.shape[0], pixels.shape[1]
    x, y, a, b, theta = ellipse[0], ellipse[1], ellipse[2], ellipse[3], ellipse[4]
    cos, sin = math.cos(theta), math.sin(theta)
    uu = a * a / (a * a + b * b) if isotropic else 1.0
    vv = b * b / (a * a + b * b) if isotropic else 1.0
    half_height = math.hypot(a * sin, b * cos)
    half_width = math.hypot(a * cos, b * sin)
    total = 0.0
    for row in range(
        max(0, math.ceil(y - half_height)), min(height, math.floor(y + half_height) + 1)
    ):
        for column in range(
            max(0, math.ceil(x - half_width)), min(width, math.floor(x + half_width) + 1)
        ):
            u = ((column - x) * cos + (row - y) * sin) / a
            v = ((row - y) * cos - (column - x) * sin) / b
            if u * u + v * v < 1.0:
                slot = slots[
                        color_bin(
                        np.int64(pixels[row, column, 0]),
                        np.int64(pixels[row, column, 1]),
                        np.int64(pixels[row, column, 2]),
                        space, n0, n1, n2,
                    )
                ]  # fmt: skip
                weight = 1.0 - (u * u * uu + v * v * vv)
                histogram[slot] += weight
                total += weight
    return total


@_kernel
def color_histograms(
    pixels: NDArray[np.uint8],
    ellipses: NDArray[np.float64],
    lattice: NDArray[np.float64],
    isotropic: bool,
    slots: NDArray[np.int32],
    space: int,
    n0: int,
    n1: int,
    n2: int,
    histograms: NDArray[np.float64],
) -> None:
    """Write each ellipse's normalized histogram (equation 3), zeros where it sees no pixel.

    An empty `lattice` means every pixel.
    """
    for n in range(ellipses.shape[0]):
        histogram = histograms[n]
        histogram[:] = 0.0
        if lattice.shape[0] > 0:
            total = _fill_lattice(
                pixels, ellipses[n], lattice, isotropic, slots, space, n0, n1, n2, histogram
            )
        else:
            total = _fill_pixels(
                pixels, ellipses[n], isotropic, slots, space, n0, n1, n2, histogram
            )
        if total > 0.0:
            histogram /= total


@_kernel
def color_distances(
    pixels: NDArray[np.uint8],
    ellipses: NDArray[np.float64],
    lattice: NDArray[np.float64],
    isotropic: bool,
    slots: NDArray[np.int32],
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
    occupied = roots.shape[0]
    histogram = np.empty(occupied + 1)
    for n in range(ellipses.shape[0]):
        histogram[:] = 0.0
        if lattice.shape[0] > 0:
            total = _fill_lattice(
                pixels, ellipses[n], lattice, isotropic, slots, space, n0, n1, n2, histogram
            )
        else:
            total = _fill_pixels(
                pixels, ellipses[n], isotropic, slots, space, n0, n1, n2, histogram
            )
        rho = 0.0
        for u in range(occupied):
            rho += roots[u] * math.sqrt(histogram[u])
        if total > 0.0:
            rho /= math.sqrt(total)
        distances[n] = math.sqrt(max(0.0, 1.0 - rho))


@_kernel
def mean_shift(
    pixels: NDArray[np.uint8],
    ellipse: NDArray[np.float64],
    slots: NDArray[np.int32],
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
    height, width = pixels.shape[0], pixels.shape[1]
    x, y, a, b, theta = ellipse[0], ellipse[1], ellipse[2], ellipse[3], ellipse[4]
    cos, sin = math.cos(theta), math.sin(theta)
    half_height = math.hypot(a * sin, b * cos)
    half_width = math.hypot(a * cos, b * sin)
    total, sum_x, sum_y = 0.0, 0.0, 0.0
    for row in range(
        max(0, math.ceil(y - half_height)), min(height, math.floor(y + half_height) + 1)
    ):
        for column in range(
            max(0, math.ceil(x - half_width)), min(width, math.floor(x + half_width) + 1)
        ):
            u = ((column - x) * cos + (row - y) * sin) / a
            v = ((row - y) * cos - (column - x) * sin) / b
            if u * u + v * v < 1.0:
                slot = slots[
                    color_bin(
                        np.int64(pixels[row, column, 0]),
                        np.int64(pixels[row, column, 1]),
                        np.int64(pixels[row, column, 2]),
                        space, n0, n1, n2,
                    )
                ]  # fmt: skip
                weight = ratios[slot]
                total += weight
                sum_x += weight * column
                sum_y += weight * row
    if total > 0.0:
        center[0] = sum_x / total
        center[1] = sum_y / total
