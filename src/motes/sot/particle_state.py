"""The state of the particle filter."""

from __future__ import annotations

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
