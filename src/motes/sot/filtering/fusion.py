"""Fusion: from the likelihoods of several cues to one weight for each particle."""

from __future__ import annotations

import math
from abc import abstractmethod
from collections.abc import Sequence
from typing import Annotated

import numpy as np
from msgspec import Meta

from motes import kernels
from motes.core.config import Config
from motes.core.geometry import Ellipse
from motes.core.types import Floats
from motes.sot.filtering.resampling import Weights

Weight = Annotated[float, Meta(gt=0, le=1e6)]
Floor = Annotated[float, Meta(ge=1e-3, le=1e6)]


class Mixture(Config, frozen=True):
    """A sum of the cues' likelihoods, weighted by their shares.

    Maggio et al., section 4.2: p(z | x) is proportional to the sum of w_j l_j(x) over the cues j,
    with weights w_j that sum to 1 (equation 10). The paper supposes "that each feature has a
    comparable measure". Here each l_j is divided by its sum over the particles: if all distances of
    one cue were larger than those of another, the first cue would have no influence otherwise.
    """

    @abstractmethod
    def shares(
        self, names: Sequence[str], likelihoods: Floats, ellipses: Floats, first: Ellipse
    ) -> Floats:
        """Return each cue's weight (J,); sum 1.

        Parameters
        ----------
        names
            The names of the cues.
        likelihoods
            (J, N), a row for each cue, normalized over the particles.
        ellipses
            (N, 5), the particles.
        first
            The target's first region.
        """

    def fuse(
        self, names: Sequence[str], prior: Floats, logs: Floats, ellipses: Floats, first: Ellipse
    ) -> tuple[Weights, Floats]:
        """Return the particles' weights and the cues' shares (J,).

        Parameters
        ----------
        names, ellipses, first
            The same as for `shares`.
        prior
            (N,), log-weights of the particles before this frame.
        logs
            (J, N), log-likelihoods, a row for each cue.
        """
        if len(names) == 1:
            return Weights.from_log(prior + logs[0]), np.array([1.0])
        likelihoods = np.array([Weights.from_log(prior + log).values for log in logs])
        shares = self.shares(names, likelihoods, ellipses, first)
        with np.errstate(divide="ignore"):  # the logarithm of 0 is -inf
            return Weights.from_log(np.log(shares @ likelihoods)), shares


class Fixed(Mixture, frozen=True, tag="fixed"):
    """Fixed weights: the same for each cue in every frame.

    Attributes
    ----------
    weights
        The weight of one cue: NAME is the cue's name, such as color. A cue with a larger weight has
        more influence. Weights need not sum to 1; a cue that is not named has weight 1.
    """

    weights: dict[str, Weight] = {}  # noqa: RUF012  (msgspec copies it)

    def shares(
        self, names: Sequence[str], likelihoods: Floats, ellipses: Floats, first: Ellipse
    ) -> Floats:
        """Return each cue's weight (J,); sum 1: always the same."""
        weights = np.array([self.weights.get(name, 1.0) for name in names])
        shares: Floats = weights / weights.sum()
        return shares


class Adaptive(Mixture, frozen=True, tag="adaptive"):
    """Weights inversely proportional to each cue's uncertainty: Maggio et al., equations 8 to 10.

    Attributes
    ----------
    floor
        Standard deviation that is added to every dimension of a cue's uncertainty, in mean
        half-axes of the first region, or radians. With a larger value, the cues get more similar
        weights. Without it, a cue that gives one particle all the weight would have no uncertainty
        at all.
    """

    floor: Floor = 0.5

    def shares(
        self, names: Sequence[str], likelihoods: Floats, ellipses: Floats, first: Ellipse
    ) -> Floats:
        """Return each cue's weight (J,); sum 1.

        A cue's uncertainty is the determinant of the particles' covariance under its likelihood
        (equation 9). The paper mixes units. Here positions count in mean half-axes of the first
        region, half-axes relative to that region's, the angle in radians.
        """
        mean = math.sqrt(first.a * first.b)
        units = np.array([mean, mean, first.a, first.b, 1.0])
        center, covariances = np.empty(5), np.empty((len(names), 5, 5))
        for likelihood, covariance in zip(
            np.ascontiguousarray(likelihoods), covariances, strict=True
        ):
            kernels.particles.moments(ellipses, likelihood, center, covariance)  # equation 8
        scaled = covariances / np.outer(units, units) + self.floor**2 * np.eye(5)
        volumes = np.linalg.slogdet(scaled)[1]  # equation 9
        certainties = np.exp(volumes.min() - volumes)
        shares: Floats = certainties / certainties.sum()
        return shares


class Product(Config, frozen=True, tag="product"):
    """The product of the cues' likelihoods, as if each were independent of the others.

    Ng and Delp do not give the rule by which they fuse color and edges. A product has no weights:
    all shares are equal. They only serve to average the cues' coefficients into one number, for the
    appearance rule and the confidence. A cue with a smaller sigma has more influence.
    """

    def fuse(
        self, names: Sequence[str], prior: Floats, logs: Floats, ellipses: Floats, first: Ellipse
    ) -> tuple[Weights, Floats]:
        """Return the particles' weights and the cues' shares (J,), as `Mixture.fuse` does."""
        return Weights.from_log(prior + logs.sum(axis=0)), np.full(len(names), 1 / len(names))


Fusion = Adaptive | Fixed | Product


def fuse_distances(distances: Floats, shares: Floats) -> Floats:
    """Return one distance per particle (N,) from those of the cues (J, N).

    1 - d² is the mean of the cues' rho, weighted by their shares.
    """
    out = np.empty(distances.shape[1])
    kernels.particles.combine(distances, shares, out)
    return out
