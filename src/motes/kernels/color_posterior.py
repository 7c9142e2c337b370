"""How probable it is that a sample is of the target, by its color of 32x32x32."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from motes.kernels.compiling import kernel, unordered


@kernel
def add_colors(
    samples: NDArray[np.float32],
    inner: tuple[float, float, float, float],
    outer: tuple[float, float, float, float],
    share: float,
    inside: NDArray[np.float32],
    outside: NDArray[np.float32],
) -> None:
    """Add `share` of 32x32x32 colors: of samples in the box `inner`, and of those not in `outer`.

    Boxes are left, top, right and bottom, in samples.
    """
    height, width = samples.shape[1], samples.shape[2]
    here, there = _inside(inner, height, width), height * width - _inside(outer, height, width)
    one, other = np.float32(share / max(here, 1)), np.float32(share / max(there, 1))
    for i in range(height):
        for j in range(width):
            if inner[1] <= i < inner[3] and inner[0] <= j < inner[2]:
                inside[_color32(samples, i, j)] += one
            elif not (outer[1] <= i < outer[3] and outer[0] <= j < outer[2]):
                outside[_color32(samples, i, j)] += other


@kernel
def _inside(box: tuple[float, float, float, float], height: int, width: int) -> int:
    """Return how many samples lie in a box."""
    across, down = 0, 0
    for j in range(width):
        across += box[0] <= j < box[2]
    for i in range(height):
        down += box[1] <= i < box[3]
    return across * down


@kernel
def color_integral(
    samples: NDArray[np.float32],
    inside: NDArray[np.float32],
    outside: NDArray[np.float32],
    out: NDArray[np.float64],
) -> None:
    """Write the sums (H + 1, W + 1), above and left of each corner, of inside / (inside + outside).

    A color that was never seen counts 1/2.
    """
    for j in range(out.shape[1]):
        out[0, j] = 0.0
    for i in range(samples.shape[1]):
        total, out[i + 1, 0] = 0.0, 0.0
        for j in range(samples.shape[2]):
            total += _posterior(inside, outside, _color32(samples, i, j))
            out[i + 1, j + 1] = out[i, j + 1] + total


@unordered
def _color32(samples: NDArray[np.float32], i: int, j: int) -> int:
    red, green, blue = int(samples[0, i, j]), int(samples[1, i, j]), int(samples[2, i, j])
    return ((red >> 3) << 10) + ((green >> 3) << 5) + (blue >> 3)


@unordered
def _posterior(inside: NDArray[np.float32], outside: NDArray[np.float32], color: int) -> float:
    return float((inside[color] + 1e-6) / (inside[color] + outside[color] + 2e-6))
