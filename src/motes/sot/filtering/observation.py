"""What the particles see in a frame."""

from __future__ import annotations

from typing import NamedTuple

from motes.core.geometry import Ellipse
from motes.core.types import Floats
from motes.sot.filtering.resampling import Weights


class Observation(NamedTuple):
    """Particles that a frame was compared with, and the estimate from them.

    Attributes
    ----------
    states, ellipses
        (N, d) and (N, 5), the particles.
    weights
        Their weights after the frame.
    distances
        (N,) to the target model, over all cues.
    shares
        (J,), the weight of each cue; sum 1.
    estimate, covariance
        The mean ellipse, and the (5, 5) covariance.
    distance
        The estimate's distance to the target model.
    appearing
        Number of particles that fulfill the appearance rule.
    support
        The sum of their weights.
    """

    states: Floats
    ellipses: Floats
    weights: Weights
    distances: Floats
    shares: Floats
    estimate: Ellipse
    covariance: Floats
    distance: float
    appearing: int
    support: float
