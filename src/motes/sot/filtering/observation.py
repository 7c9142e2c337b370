"""What the particles see in a frame."""

from __future__ import annotations

from collections.abc import Mapping

import msgspec

from motes.core.geometry import Ellipse
from motes.core.types import Floats
from motes.sot.filtering.resampling import Weights


class Observation(msgspec.Struct, frozen=True, eq=False):
    """Particles that a frame was compared with, and the estimate from them."""

    states: Floats
    ellipses: Floats
    """(N, d) and (N, 5), the particles."""
    weights: Weights
    """Their weights after the frame."""
    shares: Mapping[str, float]
    """The weight of each cue; sum 1."""
    estimate: Ellipse
    covariance: Floats
    """The mean ellipse, and the (5, 5) covariance."""
    spread: float
    """Standard deviation of the particles' places, in mean half-axes of the estimate."""
    effective_sample_size: float
    """That of the weights."""
    distance: float
    """The estimate's distance to the target model."""
    around: float
    """The mean rho of the regions beside it; 0 if the appearance rule asks for no contrast."""
    appearing: int
    """Number of particles that fulfill the appearance rule."""
    support: float
    """The sum of their weights."""
