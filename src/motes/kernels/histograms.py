"""What histograms of pixels have in common: how they are filled, and their distance.

`slots` maps each number that a pixel may have, its key, to a place in a histogram.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from motes.kernels.compiling import brief, kernel, unordered

LANES = 4


@kernel
def fill(
    keys: NDArray[np.uint32],
    weights: NDArray[np.float64],
    count: int,
    slots: NDArray[Any],
    lanes: NDArray[np.float64],
) -> None:
    """Add each pixel's weight to the slot of its key in a histogram, which is then in lane 0.

    Neighbors often share a slot; adding them in turn to four lanes keeps one addition from waiting
    for the one before.
    """
    for lane in range(LANES):
        for slot in range(lanes.shape[1]):
            lanes[lane, slot] = 0.0
    first, second, third, fourth = lanes[0], lanes[1], lanes[2], lanes[3]
    whole = count - count % LANES
    for i in range(0, whole, LANES):
        first[slots[keys[i]]] += weights[i]
        second[slots[keys[i + 1]]] += weights[i + 1]
        third[slots[keys[i + 2]]] += weights[i + 2]
        fourth[slots[keys[i + 3]]] += weights[i + 3]
    for i in range(whole, count):
        first[slots[keys[i]]] += weights[i]
    for slot in range(first.shape[0]):
        first[slot] += second[slot] + third[slot] + fourth[slot]


@unordered
def coefficient(roots: NDArray[np.float64], histogram: NDArray[np.float64]) -> float:
    """Return the Bhattacharyya coefficient of a model, by its square roots, with a histogram.

    The histogram is not normalized, and may go on behind the model's last bin; 0 if it is empty.
    """
    rho, total = 0.0, 0.0
    for u in range(roots.shape[0]):
        rho += roots[u] * math.sqrt(histogram[u])
    for u in range(histogram.shape[0]):
        total += histogram[u]
    return rho / math.sqrt(total) if total > 0.0 else 0.0


@brief
def bhattacharyya(
    histograms: NDArray[np.float64], roots: NDArray[np.float64], distances: NDArray[np.float64]
) -> None:
    """Write the distances sqrt(1 - rho) of histograms (N, m) to a model, by its square roots."""
    for n in range(histograms.shape[0]):
        distances[n] = math.sqrt(max(0.0, 1.0 - coefficient(roots, histograms[n])))
