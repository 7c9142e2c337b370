"""Fusion: from the likelihoods of several cues to one weight for each particle."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Sequence
from typing import Annotated

import numpy as np
from msgspec import Meta

from motes import kernels
from motes.core.config import Config
from motes.core.registry import Registry
from motes.core.types import Floats
from motes.sot.filtering.resampling import Weights

Weight = Annotated[float, Meta(gt=0, le=1e6)]

FLOOR = 1e-3
"""Least standard deviation of a cue's covariance, as a share of that of the predicted particles.
The paper has none: this only keeps the determinant above 0."""
EQUAL = 1e-9
"""Spread in pixels or radians below which all particles are at the same place."""
SINGULAR = 1e-9
"""Variance, as a share of the predicted one, that is added so that no determinant is 0."""


class Fusion:
    """The interface of a rule that fuses cues. A rule is also a `Config` with a tag."""

    __slots__ = ()

    @abstractmethod
    def fuse(
        self, names: Sequence[str], prior: Floats, logs: Floats, ellipses: Floats
    ) -> tuple[Weights, Floats]:
        """Return the particles' weights and the cues' shares (J,), which sum to 1.

        Parameters
        ----------
        names
            The names of the cues.
        prior
            (N,), log-weights of the particles before this frame.
        logs
            (J, N), log-likelihoods, a row for each cue; 0 for a perfect match.
        ellipses
            (N, 5), the particles.
        """

    def reliability(self, names: Sequence[str]) -> Floats:
        """Return the share (J,) of each cue in the question whether a region is the target.

        It is the same in every frame: a cue that is certain of a place alone cannot answer it.
        """
        return np.full(len(names), 1 / len(names))


class Fixed(Fusion, Config, frozen=True, tag="fixed"):
    """The product of the cues' likelihoods, each to the power of its share, the same in all frames.

    log p = J * sum of w_j log l_j over the J cues: a logarithmic opinion pool. With equal shares it
    is the product, as if each cue were independent of the others; a cue with a smaller sigma has
    more influence then. The factor J keeps the powers' sum at the number of cues.
    """

    weights: dict[str, Weight] = {}  # noqa: RUF012  (msgspec copies it)
    """The weight of one cue: NAME is the cue's name, such as color. A cue with a larger weight has
    more influence. Weights need not sum to 1; a cue that is not named has weight 1."""

    def reliability(self, names: Sequence[str]) -> Floats:
        """Return the share (J,) of each cue as the weights are, as `Fusion.reliability` does."""
        weights = [self.weights.get(name, 1.0) for name in names]
        total = sum(weights)
        return np.array([weight / total for weight in weights])

    def fuse(
        self, names: Sequence[str], prior: Floats, logs: Floats, ellipses: Floats
    ) -> tuple[Weights, Floats]:
        """Return the particles' weights and the cues' shares (J,), as `Fusion.fuse` does."""
        if len(names) == 1:
            return Weights.from_log(prior + logs[0]), np.array([1.0])
        shares = self.reliability(names)
        return Weights.from_log(prior + len(names) * (shares @ logs)), shares


class PrintedMixture(Fusion, Config, frozen=True, tag="printed_mixture"):
    """The sum of the cues' likelihoods, weighted by their certainty: Maggio et al., section 4.2.

    Equations 7 to 10 as printed: p is the sum of w_j l_j, and w_j is proportional to 1 / U_j, where
    U_j is the determinant of the covariance of the particles under l_j. A sum averages the places
    of two cues, also where one of them is wrong; `Fixed` is where they agree.
    """

    def fuse(
        self, names: Sequence[str], prior: Floats, logs: Floats, ellipses: Floats
    ) -> tuple[Weights, Floats]:
        """Return the particles' weights and the cues' shares (J,), as `Fusion.fuse` does."""
        uncertainties = log_determinants(prior, logs, ellipses)
        certainties = np.exp(uncertainties.min() - uncertainties)
        shares = certainties / certainties.sum()
        mixed = np.logaddexp.reduce(np.log(shares)[:, None] + logs, axis=0)  # equation 10
        return Weights.from_log(prior + mixed), shares


FUSIONS = Registry[type[Fusion]](
    "fusion rule", "motes.fusions", Fusion, {"fixed": Fixed, "printed_mixture": PrintedMixture}
)


def log_determinants(prior: Floats, logs: Floats, ellipses: Floats) -> Floats:
    """Return the logarithm of each cue's uncertainty (J,): Maggio et al., equations 8 and 9.

    The paper multiplies eigenvalues of unlike units. Here each dimension counts in standard
    deviations of the predicted particles, which weigh `prior`; ratios of determinants do not depend
    on the units. The square of `FLOOR` times the predicted covariance is added.
    """
    out = np.empty(len(logs))
    prior, logs, ellipses = (np.ascontiguousarray(each) for each in (prior, logs, ellipses))
    kernels.fusion.log_determinants(prior, logs, ellipses, FLOOR, EQUAL, SINGULAR, out)
    return out


def fuse_distances(distances: Floats, shares: Floats) -> Floats:
    """Return one distance per particle (N,) from those of the cues (J, N).

    1 - d² is the mean of the cues' rho, weighted by their shares.
    """
    out = np.empty(distances.shape[1])
    kernels.particles.combine(distances, shares, out)
    return out
