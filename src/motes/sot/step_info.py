"""What every tracking algorithm reports of a step."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import msgspec
import numpy as np

from motes.core.track import Track
from motes.core.types import Floats


class StepInfo(msgspec.Struct, frozen=True, eq=False):
    """What any observer of a step can read."""

    track: Track
    """The estimate."""
    ellipses: Floats = np.empty((0, 5))
    """(N, 5) the hypotheses, such as particles: x, y, a, b, theta. There may be none."""
    weights: Floats = np.empty(0)
    """(N,) their probabilities after this frame."""
    n_supporting: int | None = None
    """Number of hypotheses that fulfill the appearance rule; None without such a rule."""
    models: Mapping[str, Any] = {}
    """The target model of each cue."""
    cue_weights: Mapping[str, float] = {}
    """The weight of each cue; they sum to 1."""
    note: str | None = None
    """A line about the region of a first frame that holds nothing to follow; None elsewhere."""
