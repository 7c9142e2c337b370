"""From distances to log-likelihoods."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Annotated

import numpy as np
from msgspec import Meta
from numpy.typing import NDArray

from motes.config import Config

Floats = NDArray[np.float64]
Sigma = Annotated[float, Meta(ge=1e-3, le=1e6)]


class Gaussian(Config, frozen=True, tag="gaussian"):
    """log pi = -d² / (2 sigma²) + constant.

    Nummiaro et al., equation 10, where "variance sigma" means the standard deviation; with
    d² = 1 - rho. The factor 1 / (sqrt(2 pi) sigma) is the same for all particles and falls out.
    Maggio et al., equation 6, has exp(-(d / s)²): sigma is s / sqrt(2).

    Attributes
    ----------
    sigma
        Standard deviation of the distance; the papers give no value.
    cues
        By name, that of cues which have one of their own.
    """

    sigma: Sigma = 0.1
    cues: dict[str, Sigma] = {}  # noqa: RUF012  (msgspec copies it)

    def log(self, names: Sequence[str], distances: Floats) -> Floats:
        """Return log-likelihoods of distances (J, N) by cues of these names, up to constants."""
        sigmas = np.array([self.cues.get(name, self.sigma) for name in names])
        return distances**2 * (-0.5 / sigmas**2)[:, None]
