"""Weights of particles, and resampling."""

from __future__ import annotations

from collections.abc import Callable
from typing import Annotated, Literal

import msgspec
import numpy as np
from numpy.typing import NDArray

from motes import kernels
from motes.core.config import Config, Share
from motes.core.saved_state import Array
from motes.core.types import Floats

Indices = NDArray[np.intp]


class Weights(msgspec.Struct, frozen=True, eq=False):
    """Normalized weights, made from log-weights; invalid log-weights are repaired first.

    Attributes
    ----------
    log
        (N,), the given log-weights; NaN and +inf are replaced by -inf.
    values
        (N,), probabilities, sum 1; uniform if no particle has any weight.
    degenerate
        Whether no particle had any weight before normalization.
    """

    log: Annotated[Floats, Array(least=-np.inf)]
    values: Annotated[Floats, Array(least=0.0, total=1.0)]
    degenerate: bool

    @classmethod
    def from_log(cls, log: Floats) -> Weights:
        """Normalize log-weights (N,), N >= 1."""
        log = log.copy()
        values = np.empty_like(log)
        degenerate = kernels.particles.normalize(log, values)
        return cls(np.zeros_like(log) if degenerate else log, values, degenerate)

    @classmethod
    def uniform(cls, n: int) -> Weights:
        """Return the same weight for each of n particles."""
        values = np.empty(n)
        values.fill(1 / n)
        return cls(np.zeros(n), values, False)

    @property
    def effective_sample_size(self) -> float:
        """1 / sum of squared weights: from 1 (one particle has all weight) to N (equal weights)."""
        return kernels.particles.effective_sample_size(self.values)


def multinomial(rng: np.random.Generator, weights: Floats, n: int) -> Indices:
    """Draw n independent ancestors: Nummiaro et al., figure 2, step 1.

    Each ancestor has a uniform number r in [0, 1). A binary search in the cumulated weights c finds
    the smallest j with c_j > r. With the paper's >=, r = 0 could choose a particle of weight 0.
    """
    return _search(weights, rng.random(n))


def systematic(rng: np.random.Generator, weights: Floats, n: int) -> Indices:
    """Draw n ancestors at evenly spaced positions with one common random offset."""
    return _search(weights, (np.arange(n) + rng.random()) / n)


def stratified(rng: np.random.Generator, weights: Floats, n: int) -> Indices:
    """Draw one ancestor in each of n equal intervals of the cumulated weights."""
    return _search(weights, (np.arange(n) + rng.random(n)) / n)


def residual(rng: np.random.Generator, weights: Floats, n: int) -> Indices:
    """Take floor(n w) copies of each particle, and draw the rest by the remaining fractions."""
    expected = n * weights / weights.sum()
    copies = np.floor(expected).astype(np.intp)
    sure = np.repeat(np.arange(weights.size), copies)
    left = n - sure.size
    if left == 0:
        return sure
    return np.concatenate([sure, multinomial(rng, expected - copies, left)])


def _search(weights: Floats, positions: Floats) -> Indices:
    chosen = np.empty(positions.size, np.intp)
    kernels.particles.ancestors(np.ascontiguousarray(weights, float), positions, chosen)
    return chosen


SCHEMES: dict[str, Callable[[np.random.Generator, Floats, int], Indices]] = {
    "multinomial": multinomial,
    "systematic": systematic,
    "stratified": stratified,
    "residual": residual,
}


class Resampling(Config, frozen=True):
    """When particles are resampled, and by which method.

    Attributes
    ----------
    scheme
        Method of resampling: `multinomial` is the paper's. `systematic`, `stratified` and
        `residual` add less random variation.
    threshold
        Particles are resampled when the effective sample size falls below this share of their
        number: 1 resamples in every frame, as the paper does; 0 never does.
    """

    scheme: Literal["multinomial", "systematic", "stratified", "residual"] = "multinomial"
    threshold: Share = 1.0

    def due(self, weights: Weights) -> bool:
        """Return whether particles with these weights are to be resampled."""
        return (
            self.threshold >= 1
            or weights.effective_sample_size < self.threshold * weights.values.size
        )

    def ancestors(self, rng: np.random.Generator, weights: Weights, n: int) -> Indices:
        """Return the indices (n,) of the selected particles."""
        return SCHEMES[self.scheme](rng, weights.values, n)
