"""From a distance to a log-likelihood."""

from __future__ import annotations

from typing import Annotated

import numpy as np
from msgspec import Meta
from numpy.typing import NDArray

from motes.config import Config


class Gaussian(Config, frozen=True, tag="gaussian"):
    """log pi = -d² / (2 sigma²) + constant.

    Nummiaro et al., equation 10, where "variance sigma" means the standard deviation; with
    d² = 1 - rho. The factor 1 / (sqrt(2 pi) sigma) is the same for all particles and falls out.

    Attributes
    ----------
    sigma
        Standard deviation of the distance; the paper gives no value.
    """

    sigma: Annotated[float, Meta(ge=1e-3, le=1e6)] = 0.1

    def log(self, distances: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return log-likelihoods of distances (N,), up to a constant."""
        return distances**2 * (-0.5 / self.sigma**2)
