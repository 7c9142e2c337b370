"""What an observer of a step may want, whichever algorithm took it."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import msgspec
import numpy as np
from numpy.typing import NDArray

from motes.core.track import Track
from motes.sot.filtering.model_update import Lesson

Floats = NDArray[np.float64]


class Info(msgspec.Struct, frozen=True, eq=False):
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
    appearing
        Number of particles that fulfill the appearance rule.
    models
        The target model of each cue that this frame was compared with.
    shares
        The weight of each cue; they sum to 1.
    lessons
        What the strategy of adaptation made of this frame, for each cue whose says so; empty where
        the appearance rule does not hold.
    """

    track: Track
    ellipses: Floats
    weights: Floats
    distances: Floats
    appearing: int
    models: Mapping[str, Any]
    shares: Mapping[str, float]
    lessons: Mapping[str, Lesson] = {}
