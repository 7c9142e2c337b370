"""Weights of particles, and resampling."""

from __future__ import annotations

from abc import abstractmethod
from typing import Annotated

import msgspec
import numpy as np
from numpy.typing import NDArray

from motes import kernels
from motes.core.config import Config, Share
from motes.core.registry import Registry
from motes.core.saved_state import Array
from motes.core.types import Floats

Indices = NDArray[np.intp]


class Weights(msgspec.Struct, frozen=True, eq=False):
    """Normalized weights, made from log-weights; invalid log-weights are repaired first."""

    log: Annotated[Floats, Array(least=-np.inf)]
    """(N,), the given log-weights; NaN and +inf are replaced by -inf."""
    values: Annotated[Floats, Array(least=0.0, total=1.0)]
    """(N,), probabilities, sum 1; uniform if no particle has any weight."""
    degenerate: bool
    """Whether no particle had any weight before normalization."""

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


class Resampling:
    """The interface of a method of resampling. A method is also a `Config` with a tag."""

    __slots__ = ()

    @abstractmethod
    def due(self, weights: Weights) -> bool:
        """Return whether particles with these weights are to be resampled."""

    @abstractmethod
    def ancestors(self, rng: np.random.Generator, weights: Weights, n: int) -> Indices:
        """Return the indices (n,) of the selected particles.

        A particle is expected n times as often as it weighs.
        """


class BelowThreshold(Resampling, Config, frozen=True):
    """The base of methods that wait until few particles have most of the weight."""

    threshold: Share = 1.0
    """Particles are resampled when the effective sample size falls below this share of their
    number: 1 resamples in every frame, as the papers do; 0 never does."""

    def due(self, weights: Weights) -> bool:
        """Return whether particles with these weights are to be resampled."""
        return (
            self.threshold >= 1
            or weights.effective_sample_size < self.threshold * weights.values.size
        )

    def ancestors(self, rng: np.random.Generator, weights: Weights, n: int) -> Indices:
        """Return the indices (n,) of the selected particles."""
        chosen = np.empty(n, np.intp)
        kernels.particles.ancestors(weights.values, self._positions(rng, n), chosen)
        return chosen

    @abstractmethod
    def _positions(self, rng: np.random.Generator, n: int) -> Floats:
        """Return where in the cumulated weights, 0 to 1, a particle is taken."""


class Multinomial(BelowThreshold, frozen=True, tag="multinomial"):
    """Independent draws, as in the papers: Nummiaro et al., figure 2, step 1.

    Each ancestor has a uniform number r in [0, 1). A binary search in the cumulated weights c finds
    the smallest j with c_j > r. With the paper's >=, r = 0 could choose a particle of weight 0.
    """

    def _positions(self, rng: np.random.Generator, n: int) -> Floats:
        return rng.random(n)


class Systematic(BelowThreshold, frozen=True, tag="systematic"):
    """Evenly spaced positions in the cumulated weights, with one common random offset.

    It adds less random variation than `Multinomial`.
    """

    def _positions(self, rng: np.random.Generator, n: int) -> Floats:
        return (np.arange(n) + rng.random()) / n


RESAMPLINGS = Registry[type[Resampling]](
    "method of resampling",
    "motes.resamplings",
    Resampling,
    {"multinomial": Multinomial, "systematic": Systematic},
)
