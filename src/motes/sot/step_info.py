"""What an observer of a step may want, whichever algorithm took it."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import msgspec
import numpy as np
from numpy.typing import NDArray

from motes.core.track import Track
from motes.sot.filtering.model_update import UpdateDiagnostics

Floats = NDArray[np.float64]


class StepInfo(msgspec.Struct, frozen=True, eq=False):
    """What an observer of a step may want.

    Attributes
    ----------
    track
        The estimate.
    ellipses
        (N, 5) the particles: x, y, a, b, theta.
    weights
        (N,) their probabilities after this frame.
    distances
        (N,) to the target model, over all cues.
    n_supporting
        Number of particles that fulfill the appearance rule.
    models
        The target model of each cue that this frame was compared with.
    cue_weights
        The weight of each cue; they sum to 1.
    update_diagnostics
        What the strategy of adaptation made of this frame, for each cue whose says so; empty where
        the appearance rule does not hold.
    """

    track: Track
    ellipses: Floats
    weights: Floats
    distances: Floats
    n_supporting: int
    models: Mapping[str, Any]
    cue_weights: Mapping[str, float]
    update_diagnostics: Mapping[str, UpdateDiagnostics] = {}
