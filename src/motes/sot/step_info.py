"""What every tracking algorithm reports of a step."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Protocol

from motes.core.track import Track
from motes.core.types import Floats


class StepInfo(Protocol):
    """What any observer of a step can read; an algorithm's own info may hold more.

    See `FilterInfo`, `MeanShiftInfo` and `DiscriminativeInfo`.
    """

    @property
    def track(self) -> Track:
        """The estimate."""
        ...

    @property
    def ellipses(self) -> Floats:
        """(N, 5) the hypotheses: x, y, a, b, theta. There may be none."""
        ...

    @property
    def weights(self) -> Floats:
        """(N,) their probabilities after this frame."""
        ...

    @property
    def n_supporting(self) -> int | None:
        """Number of hypotheses that fulfill the appearance rule; None without such a rule."""
        ...

    @property
    def models(self) -> Mapping[str, Any]:
        """The target model of each cue."""
        ...

    @property
    def cue_weights(self) -> Mapping[str, float]:
        """The weight of each cue; they sum to 1."""
        ...
