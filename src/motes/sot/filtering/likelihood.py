"""Likelihoods: the map from distances to log-likelihoods."""

from __future__ import annotations

import math
from abc import abstractmethod
from typing import Annotated

import numpy as np
from msgspec import Meta

from motes import kernels
from motes.core.config import Config, Share
from motes.core.registry import Registry
from motes.core.types import Floats

Sigma = Annotated[float, Meta(ge=1e-3, le=1e6)]


class Likelihood:
    """The interface of a likelihood. A likelihood is also a `Config` with a tag."""

    __slots__ = ()

    @abstractmethod
    def log(self, distances: Floats) -> Floats:
        """Return log-likelihoods (J, N) of distances (J, N), a row for each cue.

        They fall as the distance grows, from 0 or nearly 0 for a perfect match.
        """


class Gaussian(Likelihood, Config, frozen=True, tag="gaussian"):
    """Gaussian likelihood of the distance d, with the same sigma in all frames.

    log pi = log(exp(-d² / (2 sigma²)) + epsilon) + constant.

    Nummiaro et al., equation 10, where "variance sigma" means the standard deviation; with
    d² = 1 - rho. The factor 1 / (sqrt(2 pi) sigma) is the same for all particles and cancels out.
    Maggio et al., equation 6, has exp(-(d / s)²): sigma is s / sqrt(2). Ng and Delp have it as
    equation 22, and with epsilon as equation 23.
    """

    sigma: Sigma = 0.1
    """Standard deviation of the distance between a particle and the target model, 0 to 1. With a
    larger value, good and bad particles get more similar weights. The papers give no value."""
    epsilon: Share = 0.0
    """Constant added to the likelihood, which is 1 for a perfect match. A larger value gives bad
    particles more weight."""

    def log(self, distances: Floats) -> Floats:
        """Return log-likelihoods of distances (J, N), up to constants."""
        sigmas = np.full(len(distances), self.sigma)
        logs = np.empty(distances.shape)
        kernels.particles.gaussian(np.ascontiguousarray(distances), sigmas, self.epsilon, logs)
        return logs


class BestParticle(Likelihood, Config, frozen=True, tag="best_particle"):
    """Gaussian likelihood whose sigma follows the best particle of each frame, for each cue.

    Ng and Delp, equation 24, with log L = -1: sigma = d_min / sqrt(2), where d_min is the smallest
    of all particles' distances. The best particle then always has exp(-1) + epsilon.
    """

    epsilon: Share = 0.001
    """Constant added to the likelihood, which is exp(-1) for the best particle. A larger value
    gives bad particles more weight. The paper has "small but non-zero"; with the 0.1 of its figure
    3, where "weights equal sigma" means epsilon, many bad particles outweigh a few good ones."""
    floor: Sigma = 0.02
    """Least value of sigma. With a larger value, good and bad particles get more similar weights.
    Without it, a particle at distance 0 would take all the weight. The default is as large as the
    error of a distance when half or a quarter of a region's pixels are read (table 1)."""

    def log(self, distances: Floats) -> Floats:
        """Return log-likelihoods of distances (J, N), up to constants."""
        sigmas = np.maximum(distances.min(axis=1) / math.sqrt(2), self.floor)
        logs = np.empty(distances.shape)
        kernels.particles.gaussian(np.ascontiguousarray(distances), sigmas, self.epsilon, logs)
        return logs


class Exponential(Likelihood, Config, frozen=True, tag="exponential"):
    """Exponential likelihood of the distance: Zhao and Pei, section 2.3.

    log pi = -lambda d + constant. The paper calls the distance rho.
    """

    rate: Annotated[float, Meta(gt=0, le=1e6)] = 20.0
    """Factor lambda of the distance. With a larger value, the best particles get more of the
    weight. The paper gives no value."""

    def log(self, distances: Floats) -> Floats:
        """Return log-likelihoods of distances (J, N), up to constants."""
        return -self.rate * distances


LIKELIHOODS = Registry[type[Likelihood]](
    "likelihood",
    "motes.likelihoods",
    Likelihood,
    {"gaussian": Gaussian, "best_particle": BestParticle, "exponential": Exponential},
)
