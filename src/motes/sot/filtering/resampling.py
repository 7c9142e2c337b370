"""The weights of particles: their resampling, their number and their moments."""

from __future__ import annotations

import math
from abc import abstractmethod
from typing import Annotated

import msgspec
import numpy as np
from msgspec import Meta
from numpy.typing import NDArray

from motes import kernels
from motes.core.config import Config, Particles, Share
from motes.core.errors import ConfigError
from motes.core.geometry import Ellipse
from motes.core.registry import Registry
from motes.core.types import Floats

Indices = NDArray[np.intp]


class Weights(msgspec.Struct, frozen=True, eq=False):
    """Normalized weights, made from log-weights; invalid log-weights are repaired first."""

    log: Floats
    """(N,), the given log-weights; NaN and +inf are replaced by -inf."""
    values: Floats
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


QUANTILE = 2.326
"""The 99 % quantile of the normal distribution."""


class KldSampling(Config, frozen=True):
    """KLD sampling: the farther the particles spread, the more particles there are.

    Fox, KLD-sampling: adaptive particle filters, NIPS 2001, equation 7. n samples estimate the
    distribution over k bins, with a probability of 99 %, to a Kullback-Leibler divergence of at
    most `error`. Here k is the number of bins that hold particles of the last frame, before they
    are weighted. So the number of particles is known before the next frame.
    """

    min: Particles = 50
    """Least number of particles."""
    max: Particles = 500
    """Largest number of particles."""
    error: Annotated[float, Meta(gt=0, le=10)] = 0.2
    """Largest Kullback-Leibler divergence between the particles and the distribution of the
    target's place, with a probability of 99 %. A larger value uses fewer particles."""
    bin: Annotated[float, Meta(ge=1e-3, le=100)] = 1.0
    """Side of a bin: in mean half-axes of the target's first region for x and y, in natural
    logarithms for its size. A larger value uses fewer particles."""

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.min > self.max:
            raise ConfigError(
                f"min is {self.min}, and max is {self.max}; make min smaller, or max larger."
            )

    def count(self, ellipses: Floats, first: Ellipse) -> int:
        """Return the number of particles for the spread of ellipses (N, 5)."""
        unit = math.sqrt(first.a * first.b)
        places = np.empty((len(ellipses), 3))
        places[:, :2] = ellipses[:, :2] / unit
        places[:, 2] = 0.5 * np.log(ellipses[:, 2] * ellipses[:, 3])
        bins = np.floor(places / self.bin).astype(np.int64)
        return self.needed(len(set((bins @ [1, 1 << 20, 1 << 40]).tolist())))

    def needed(self, bins: int) -> int:
        """Return the number of particles for a distribution over bins; one bin needs one."""
        if bins < 2:
            return self.allowed(1)
        spread = 2 / (9 * (bins - 1))
        shape = (1 - spread + math.sqrt(spread) * QUANTILE) ** 3
        return self.allowed(math.ceil((bins - 1) / (2 * self.error) * shape))

    def allowed(self, number: int) -> int:
        """Return the number of particles between `min` and `max` that is nearest to a number."""
        return min(max(number, self.min), self.max)


def mean_ellipse(ellipses: Floats, weights: Floats) -> tuple[Ellipse, Floats]:
    """Return the mean E[S] = sum of pi s (Nummiaro et al., equation 1) and its covariance.

    Ellipses are (N, 5), and the weights (N,) have the sum 1; the covariance is (5, 5). An ellipse
    is the same after half a turn, so the angle's mean and deviations are taken modulo pi; the mean
    is in (-pi/2, pi/2].
    """
    mean, covariance = np.empty(5), np.empty((5, 5))
    kernels.particles.moments(ellipses, weights, mean, covariance)
    return Ellipse(*mean.tolist()), covariance
