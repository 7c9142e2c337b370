"""The state of the particle filter, and the check of a saved state."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, TypeAlias

import msgspec
import numpy as np
from msgspec.structs import replace

from motes.core.frame import Frame
from motes.core.geometry import Ellipse
from motes.core.saved_state import in_types_of, middle_of
from motes.core.track import Status
from motes.core.types import Floats
from motes.cues.base import Cue
from motes.sot.filtering.appearance_rule import BackgroundStatistics
from motes.sot.filtering.model_update import Strategy, UpdaterState
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


def typed_state(
    state: FilterState,
    frame: Frame,
    cues: Mapping[str, Cue],
    strategies: Mapping[str, Strategy],
) -> FilterState:
    """Return a saved state with models and memories in their types, which the cues know.

    Raises a ValueError if it is of another configuration.
    """
    middle = middle_of(frame, *state.reference_size[2:4])
    models = {name: cue.learn(frame, middle) for name, cue in cues.items()}
    memories = dict[str, UpdaterState]()
    for name in filter(strategies.get, state.memories):
        flat = np.full_like(models[name].histogram, 1 / len(models[name].histogram))
        memory = strategies[name].learn(None, flat, flat, flat).memory
        if memory is not None:
            memories[name] = memory
    return replace(
        state,
        models=in_types_of(models, state.models, "state.models"),
        memories=in_types_of(memories, state.memories, "state.memories"),
    )
