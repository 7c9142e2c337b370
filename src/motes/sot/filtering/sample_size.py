"""The number of particles, from their spread."""

from __future__ import annotations

import math
from typing import Annotated

import numpy as np
from msgspec import Meta

from motes.core.config import Config, Particles
from motes.core.errors import ConfigError
from motes.core.geometry import Ellipse
from motes.core.types import Floats

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
        return self.number(places)

    def number(self, places: Floats) -> int:
        """Return the number of particles for the spread of places (N, d), in units of a bin."""
        bins = np.floor(places / self.bin).astype(np.int64)
        k = len(set((bins @ [1 << 20 * axis for axis in range(bins.shape[1])]).tolist()))
        return self.allowed(self._needed(k))

    def allowed(self, number: int) -> int:
        """Return the number of particles between `min` and `max` that is nearest to a number."""
        return min(max(number, self.min), self.max)

    def _needed(self, bins: int) -> int:
        """Return n for k bins; one bin needs one particle."""
        if bins < 2:
            return 1
        spread = 2 / (9 * (bins - 1))
        shape = (1 - spread + math.sqrt(spread) * QUANTILE) ** 3
        return math.ceil((bins - 1) / (2 * self.error) * shape)
