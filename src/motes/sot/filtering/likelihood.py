"""From distances to log-likelihoods."""

from __future__ import annotations

import math
from abc import abstractmethod
from collections.abc import Sequence
from typing import Annotated

import numpy as np
from msgspec import Meta

from motes import kernels
from motes.core.config import Config, Share
from motes.core.registry import Registry
from motes.core.types import Floats

Sigma = Annotated[float, Meta(ge=1e-3, le=1e6)]


class Likelihood:
    """The interface of a likelihood, which is also a `Config` with a tag."""

    __slots__ = ()

    @abstractmethod
    def log(self, names: Sequence[str], distances: Floats) -> Floats:
        """Return log-likelihoods (J, N) of distances (J, N) by cues of these names.

        They are known up to a constant for each cue, and fall as the distance grows.
        """


class Gaussian(Likelihood, Config, frozen=True, tag="gaussian"):
    """log pi = log(exp(-d² / (2 sigma²)) + epsilon) + constant.

    Nummiaro et al., equation 10, where "variance sigma" means the standard deviation; with
    d² = 1 - rho. The factor 1 / (sqrt(2 pi) sigma) is the same for all particles and falls out.
    Maggio et al., equation 6, has exp(-(d / s)²): sigma is s / sqrt(2). Ng and Delp, equation 22,
    and 23 with epsilon.

    Attributes
    ----------
    sigma
        Standard deviation of the distance; the papers give no value.
    cues
        By name, that of cues which have one of their own.
    epsilon
        What the worst particles are left with beside the 1 of a perfect match, all of them alike.
    """

    sigma: Sigma = 0.1
    cues: dict[str, Sigma] = {}  # noqa: RUF012  (msgspec copies it)
    epsilon: Share = 0.0

    def log(self, names: Sequence[str], distances: Floats) -> Floats:
        """Return log-likelihoods of distances (J, N) by cues of these names, up to constants."""
        sigmas = np.array([self.cues.get(name, self.sigma) for name in names])
        logs = np.empty_like(distances)
        kernels.particles.gaussian(distances, sigmas, self.epsilon, logs)
        return logs


class BestParticle(Likelihood, Config, frozen=True, tag="best_particle"):
    """The same with the sigma of each cue set in each frame by its best particle.

    Ng and Delp, equation 24, with log L = -1: sigma = d_min / sqrt(2), where d_min is the smallest
    of all particles' distances. The best particle then always has exp(-1) + epsilon.

    Attributes
    ----------
    epsilon
        As in `Gaussian`. "Small but non-zero": many bad particles must not outweigh a few good
        ones, as they do with the 0.1 of figure 3, below which "weights equal sigma" means epsilon.
    floor
        Sigma is never less: a particle at no distance at all would leave nothing to any other. As
        large as the distance that comes of reading half or a quarter of a region's pixels (table
        1), below which distances mean little.
    """

    epsilon: Share = 0.001
    floor: Sigma = 0.02

    def log(self, names: Sequence[str], distances: Floats) -> Floats:
        """Return log-likelihoods of distances (J, N) by cues of these names, up to constants."""
        sigmas = np.maximum(distances.min(axis=1) / math.sqrt(2), self.floor)
        logs = np.empty_like(distances)
        kernels.particles.gaussian(distances, sigmas, self.epsilon, logs)
        return logs


class Exponential(Likelihood, Config, frozen=True, tag="exponential"):
    """log pi = -lambda d + constant: Zhao and Pei, section 2.3, where rho means the distance.

    Attributes
    ----------
    rate
        lambda; the paper gives no value.
    """

    rate: Annotated[float, Meta(gt=0, le=1e6)] = 20.0

    def log(self, names: Sequence[str], distances: Floats) -> Floats:
        """Return log-likelihoods of distances (J, N) by cues of these names, up to constants."""
        return -self.rate * distances


LIKELIHOODS = Registry[Likelihood](
    "likelihood",
    "motes.likelihoods",
    Likelihood,
    {"gaussian": Gaussian, "best_particle": BestParticle, "exponential": Exponential},
)
