"""How many particles: as many as the spread of the target's whereabouts asks for, in time."""

from __future__ import annotations

import math
import statistics
from collections import deque
from typing import Annotated

import numpy as np
from msgspec import Meta
from numpy.typing import NDArray

from motes.core.config import Config, Particles
from motes.core.errors import ConfigError
from motes.core.geometry import Ellipse

Floats = NDArray[np.float64]
QUANTILE = 2.326
"""Of the normal distribution, at 99 %."""


class KldSampling(Config, frozen=True):
    """KLD sampling: more particles where the target may be in more places, and fewer where not.

    Fox, KLD-sampling: adaptive particle filters, NIPS 2001, equation 7: with n samples the
    distribution over k bins is estimated, with a probability of 99 %, to a Kullback-Leibler
    divergence of at most `error`. The bins that count are those that the last frame's particles lie
    in, before they are weighed: a frame's number is known before it comes.

    Attributes
    ----------
    min, max
        The number of particles is never outside this range.
    error
        The divergence that is allowed.
    bin
        Side of a bin: in mean half-axes of the target's first region for x and y, in natural
        logarithms for its size.
    """

    min: Particles = 50
    max: Particles = 500
    error: Annotated[float, Meta(gt=0, le=10)] = 0.2
    bin: Annotated[float, Meta(ge=1e-3, le=100)] = 1.0

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.min > self.max:
            raise ConfigError(f"least is {self.min}, and most is {self.max}; exchange them.")

    def count(self, ellipses: Floats, first: Ellipse) -> int:
        """Return how many particles the spread of ellipses (N, 5) asks for."""
        unit = math.sqrt(first.a * first.b)
        places = np.empty((len(ellipses), 3))
        places[:, :2] = ellipses[:, :2] / unit
        places[:, 2] = 0.5 * np.log(ellipses[:, 2] * ellipses[:, 3])
        return self.number(places)

    def number(self, places: Floats) -> int:
        """Return how many particles the spread of places (N, d) asks for, in the units of a bin."""
        bins = np.floor(places / self.bin).astype(np.int64)
        k = len(np.unique(bins @ [1 << 20 * axis for axis in range(bins.shape[1])]))
        return min(max(self._needed(k), self.min), self.max)

    def _needed(self, bins: int) -> int:
        """Return n for k bins; one bin needs no more than one particle."""
        if bins < 2:
            return 1
        spread = 2 / (9 * (bins - 1))
        shape = (1 - spread + math.sqrt(spread) * QUANTILE) ** 3
        return math.ceil((bins - 1) / (2 * self.error) * shape)


class SpeedBudget:
    """Learns from the time that steps take how many particles a rate of frames allows.

    Parameters
    ----------
    fps
        Frames a second: a step shall take no longer than 1 / fps.
    """

    def __init__(self, fps: float) -> None:
        if not (math.isfinite(fps) and fps > 0):
            raise ConfigError(f"A rate of frames is a positive number; got {fps:g}.")
        self._seconds = 1 / fps
        self._costs: deque[float] = deque(maxlen=RECENT)

    def add(self, seconds: float, particles: int) -> None:
        """Take note of a step."""
        self._costs.append(seconds / particles)

    @property
    def max_particles(self) -> int | None:
        """So many particles can be afforded; None before anything is known."""
        if not self._costs:
            return None
        return int(self._seconds / statistics.median(self._costs))


RECENT = 15
"""Steps whose median counts: a single slow one does not matter."""
