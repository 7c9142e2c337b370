"""Several cues, one weight for each particle: a mixture or the product of the cues' likelihoods."""

from __future__ import annotations

import math
from abc import abstractmethod
from collections.abc import Sequence
from typing import Annotated

import numpy as np
from msgspec import Meta
from numpy.typing import NDArray

from motes import kernels
from motes.core.config import Config
from motes.core.geometry import Ellipse
from motes.sot.filtering.resampling import Weights

Floats = NDArray[np.float64]
Weight = Annotated[float, Meta(gt=0, le=1e6)]
Floor = Annotated[float, Meta(ge=1e-3, le=1e6)]


class Mixture(Config, frozen=True):
    """A sum of the cues' likelihoods, weighted by their shares.

    Maggio et al., section 4.2: p(z | x) is proportional to the sum of w_j l_j(x) over the cues j,
    with weights w_j that sum to 1 (equation 10). "Suppose that each feature has a comparable
    measure": here each l_j is divided by its sum over the particles, since the distances of one cue
    may all be larger than those of another, which would leave the first one without any say.
    """

    @abstractmethod
    def shares(
        self, names: Sequence[str], likelihoods: Floats, ellipses: Floats, first: Ellipse
    ) -> Floats:
        """Return each cue's weight (J,); sum 1.

        Parameters
        ----------
        names
            Of the cues.
        likelihoods
            (J, N) by cue, each normalized over the particles.
        ellipses
            (N, 5) the particles.
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
            As `shares` has them.
        prior
            (N,) log-weights of the particles before this frame.
        logs
            (J, N) log-likelihoods by cue.
        """
        if len(names) == 1:
            return Weights.from_log(prior + logs[0]), np.array([1.0])
        likelihoods = np.array([Weights.from_log(prior + log).values for log in logs])
        shares = self.shares(names, likelihoods, ellipses, first)
        with np.errstate(divide="ignore"):  # no likelihood at all is -inf
            return Weights.from_log(np.log(shares @ likelihoods)), shares


class Fixed(Mixture, frozen=True, tag="fixed"):
    """The same weights in every frame.

    Attributes
    ----------
    weights
        By cue; they need not sum to 1, and a cue that is not named has 1.
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
    """Weights inversely proportional to each cue's uncertainty (equations 8 to 10).

    Attributes
    ----------
    floor
        Standard deviation that every dimension has in addition: differences below it do not matter.
        Without it, a cue that gives one particle all the weight would have no uncertainty at all.
    """

    floor: Floor = 0.5

    def shares(
        self, names: Sequence[str], likelihoods: Floats, ellipses: Floats, first: Ellipse
    ) -> Floats:
        """Return each cue's weight (J,); sum 1.

        A cue's uncertainty is the determinant of the particles' covariance under its likelihood
        (equation 9). The paper has it over unlike units; here positions count in mean half-axes of
        the first region, half-axes relative to that region's, the angle in radians.
        """
        mean = math.sqrt(first.a * first.b)
        units = np.array([mean, mean, first.a, first.b, 1.0])
        volumes = np.empty(len(names))
        center, covariance = np.empty(5), np.empty((5, 5))
        for j, likelihood in enumerate(likelihoods):
            kernels.particles.moments(ellipses, likelihood, center, covariance)  # equation 8
            scaled = covariance / np.outer(units, units) + self.floor**2 * np.eye(5)
            volumes[j] = np.linalg.slogdet(scaled)[1]  # equation 9
        certainties = np.exp(volumes.min() - volumes)
        shares: Floats = certainties / certainties.sum()
        return shares


class Product(Config, frozen=True, tag="product"):
    """The product of the cues' likelihoods, as if each were independent of the others.

    Ng and Delp do not say how color and edges become one. A product has no weights: all shares are
    the same, and only say how the cues' coefficients are averaged where one number is wanted, as
    for the appearance rule and the confidence. A cue has the more to say, the smaller its sigma.
    """

    def fuse(
        self, names: Sequence[str], prior: Floats, logs: Floats, ellipses: Floats, first: Ellipse
    ) -> tuple[Weights, Floats]:
        """Return the particles' weights and the cues' shares (J,), as `Mixture.fuse` does."""
        return Weights.from_log(prior + logs.sum(axis=0)), np.full(len(names), 1 / len(names))


Fusion = Adaptive | Fixed | Product


def fuse_distances(distances: Floats, shares: Floats) -> Floats:
    """Return the distances (N,) over all cues, of (J, N): 1 - d² is the mean of the cues' rho."""
    out = np.empty(distances.shape[1])
    kernels.particles.combine(distances, shares, out)
    return out
