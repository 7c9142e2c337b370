"""The state of the particle filter, and what its particles see in a frame."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, TypeAlias

import msgspec

from motes.core.geometry import Ellipse
from motes.core.track import Status
from motes.core.types import Floats
from motes.sot.filtering.appearance_rule import BackgroundStatistics
from motes.sot.filtering.model_update import UpdaterState
from motes.sot.filtering.resampling import Weights

Model: TypeAlias = Any
"""A target model; its type is the cue's own affair."""


class FilterState(msgspec.Struct, frozen=True, eq=False):
    """The state after a frame."""

    time: float
    """Time of the last frame, in seconds."""
    states: Floats
    """(N, d) the particles, in the columns of the motion model."""
    weights: Weights
    """Weights of the particles after the last frame."""
    models: dict[str, Model]
    """The target model of each cue."""
    memories: dict[str, UpdaterState]
    """What the model update remembers, for each cue whose update remembers something."""
    backgrounds: dict[str, BackgroundStatistics]
    """Background statistics of the appearance rule, for each cue."""
    reference_size: Ellipse
    """The target's first region; all noise is proportional to its size."""
    search_regions: Floats
    """(R, 4) boxes over which particles are spread in a search."""
    status: Status
    frames_missed: int
    """The status, and the number of frames in a row that were against it by the appearance rule."""
    known: bool = False
    """Whether the target was known before it was seen."""


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
