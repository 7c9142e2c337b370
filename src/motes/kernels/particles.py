"""Particles: their motion, selection, weights and mean."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from motes.kernels.compiling import brief


@brief
def walk(
    states: NDArray[np.float64],
    normal: NDArray[np.float64],
    deviations: NDArray[np.float64],
    steps: float,
    kept: float,
    a: float,
    b: float,
    kept_size: float,
    size_deviation: float,
    out: NDArray[np.float64],
) -> None:
    """Write the states (N, 5 + 4k) that follow: x, y, a, b, theta and k orders of their changes.

    A column takes its normal number times its deviation, and `steps` times the new value of its
    change. Of a change the share `kept` is left; half-axes keep `kept_size` of their distance, in
    logarithms, to the first ones `a` and `b`, and are then scaled by a common factor, whose
    logarithm is the last normal number times `size_deviation`. They stay at one pixel or more.
    """
    columns = states.shape[1]
    for n in range(states.shape[0]):
        for i in range(columns - 1, 4, -1):
            out[n, i] = kept * states[n, i] + deviations[i] * normal[n, i]
            if i + 4 < columns:
                out[n, i] += steps * out[n, i + 4]
        for i in range(5):
            out[n, i] = states[n, i] + deviations[i] * normal[n, i]
            if i < 4 and columns > 5:
                out[n, i] += steps * out[n, i + 5]
        growth = size_deviation * normal[n, columns]
        out[n, 2] = max(a * math.exp(kept_size * math.log(max(out[n, 2], 1.0) / a) + growth), 1.0)
        out[n, 3] = max(b * math.exp(kept_size * math.log(max(out[n, 3], 1.0) / b) + growth), 1.0)


@brief
def ancestors(
    weights: NDArray[np.float64], positions: NDArray[np.float64], chosen: NDArray[np.intp]
) -> None:
    """Write, for each position from 0 to 1, the first particle whose cumulated weight exceeds it.

    Positions are shares of the sum of weights; a particle without weight is never chosen, if any
    has one.
    """
    cumulated = np.empty(weights.shape[0])
    total, last = 0.0, 0
    for n in range(weights.shape[0]):
        total += weights[n]
        cumulated[n] = total
        if weights[n] > 0.0:
            last = n
    for i in range(positions.shape[0]):
        position = positions[i] * total
        low, high = 0, last  # rounding may lift the largest position onto the last sum
        while low < high:
            middle = (low + high) >> 1
            if cumulated[middle] > position:
                high = middle
            else:
                low = middle + 1
        chosen[i] = low


@brief
def gaussian(
    distances: NDArray[np.float64],
    sigmas: NDArray[np.float64],
    epsilon: float,
    logs: NDArray[np.float64],
) -> None:
    """Write log(exp(-d² / (2 sigma²)) + epsilon) of distances (J, N) and sigmas (J,)."""
    for j in range(distances.shape[0]):
        scale = -0.5 / (sigmas[j] * sigmas[j])
        for n in range(distances.shape[1]):
            log = scale * distances[j, n] * distances[j, n]
            logs[j, n] = math.log(math.exp(log) + epsilon) if epsilon > 0.0 else log


@brief
def normalize(logs: NDArray[np.float64], values: NDArray[np.float64]) -> bool:
    """Write probabilities for log-weights, whose NaN and +inf become -inf; True if none has any.

    They are then uniform.
    """
    top = -np.inf
    for n in range(logs.shape[0]):
        if not logs[n] < np.inf:
            logs[n] = -np.inf
        top = max(top, logs[n])
    if top == -np.inf:
        for n in range(values.shape[0]):
            values[n] = 1.0 / logs.shape[0]
        return True
    total = 0.0
    for n in range(logs.shape[0]):
        values[n] = math.exp(logs[n] - top)
        total += values[n]
    for n in range(logs.shape[0]):
        values[n] /= total
    return False


@brief
def combine(
    distances: NDArray[np.float64], shares: NDArray[np.float64], out: NDArray[np.float64]
) -> None:
    """Write the root of the mean of the squared distances (J, N) of cues by their shares (J,)."""
    for n in range(out.shape[0]):
        out[n] = 0.0
    for j in range(distances.shape[0]):
        for n in range(distances.shape[1]):
            out[n] += shares[j] * distances[j, n] * distances[j, n]
    for n in range(out.shape[0]):
        out[n] = math.sqrt(out[n])


@brief
def appearing(
    distances: NDArray[np.float64], weights: NDArray[np.float64], threshold: float
) -> tuple[int, float]:
    """Return how many particles have a rho, 1 - d², above a threshold, and the sum of weights."""
    count, support = 0, 0.0
    for n in range(distances.shape[0]):
        if 1.0 - distances[n] * distances[n] > threshold:
            count += 1
            support += weights[n]
    return count, support


@brief
def moments(
    ellipses: NDArray[np.float64],
    weights: NDArray[np.float64],
    mean: NDArray[np.float64],
    covariance: NDArray[np.float64],
) -> None:
    """Write the weighted mean (5,) and covariance (5, 5) of ellipses, angles modulo pi."""
    for i in range(5):
        mean[i] = 0.0
        for j in range(5):
            covariance[i, j] = 0.0
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
            weighted = weights[n] * off[i]
            for j in range(i + 1):
                covariance[i, j] += weighted * off[j]
    for i in range(5):
        for j in range(i):
            covariance[j, i] = covariance[i, j]
