"""Model updates: how a target model learns from the region in which the target was found.

They serve every cue that compares histograms. A strategy is a pure function. It takes the
histograms of the model, of the first frame and of this frame, and its memory. It returns the new
histogram of the model and its new memory.
"""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Mapping
from typing import Any, NamedTuple, TypeAlias

from msgspec.structs import replace

from motes.core.config import Config, Share
from motes.core.frame import Frame
from motes.core.geometry import Ellipse
from motes.core.registry import Registry
from motes.core.types import Floats
from motes.cues.base import AdaptableCue, Cue

UpdaterState: TypeAlias = Any
"""The memory of a strategy for one cue: a frozen `msgspec.Struct` of its own, or None."""


class UpdateResult(NamedTuple):
    """The next histogram of a model, and the memory of its strategy, if any."""

    histogram: Floats
    memory: UpdaterState = None


class Adaptation:
    """The interface of a model update: one strategy for all cues, or one for each."""

    __slots__ = ()

    @abstractmethod
    def strategy(self, cue: str) -> Strategy:
        """Return the strategy for the cue of a name."""


class Strategy(Adaptation):
    """The interface of a rule by which a model learns. It is also a `Config` with a tag."""

    __slots__ = ()

    def strategy(self, cue: str) -> Strategy:
        """Return itself: all cues learn alike."""
        return self

    @property
    def learns(self) -> bool:
        """Whether the model ever changes."""
        return True

    @abstractmethod
    def learn(
        self, memory: UpdaterState, histogram: Floats, first: Floats, seen: Floats
    ) -> UpdateResult:
        """Return the new histogram of a model, and the new memory.

        Parameters
        ----------
        memory
            The memory after the last frame; None in the beginning.
        histogram, first, seen
            (m,) each: the histogram of the model, of the first frame and of this frame. The last
            one is not empty.
        """


class ExponentialForgetting(Strategy, Config, frozen=True, tag="forgetting"):
    """Exponential forgetting: the model moves by a fixed share in each frame.

    Nummiaro et al. name such models in sections IV and VIII.
    """

    learning_rate: Share = 0.0
    """Share of the current frame in the updated model. With a larger value the model follows
    changes faster; 0 keeps it fixed."""
    anchor: Share = 0.0
    """Share of the first frame's histogram in what the model moves towards; the rest is the current
    frame's. With a larger value the model stays nearer to the first frame's."""

    @property
    def learns(self) -> bool:
        """Whether the rate is above 0."""
        return self.learning_rate > 0

    def learn(
        self, memory: UpdaterState, histogram: Floats, first: Floats, seen: Floats
    ) -> UpdateResult:
        """Return the model moved towards this frame's histogram; there is no memory."""
        entering = self.anchor * first + (1 - self.anchor) * seen
        return UpdateResult((1 - self.learning_rate) * histogram + self.learning_rate * entering)


class PerCue(Adaptation, Config, frozen=True, tag="per_cue"):
    """A model update of its own for each cue."""

    cues: dict[str, Strategy] = {}  # noqa: RUF012  (msgspec copies it)
    """The model update of one cue: NAME is the cue's name, such as color. The model of a cue that
    is not named stays fixed."""

    def strategy(self, cue: str) -> Strategy:
        """Return the strategy of the cue with a name; by default one that keeps the model fixed."""
        return self.cues.get(cue, ExponentialForgetting())


MODEL_UPDATES = Registry[type[Adaptation]](
    "model update",
    "motes.model_updates",
    Adaptation,
    {
        "forgetting": ExponentialForgetting,
        "kalman": "motes.sot.filtering.bin_updates:KalmanBins",
        "gaussian": "motes.sot.filtering.bin_updates:GaussianBins",
        "anchored_kalman": "motes.sot.filtering.bin_updates:AnchoredKalman",
        "per_cue": PerCue,
    },
)


def update_models(
    cues: Mapping[str, Cue],
    strategies: Mapping[str, Strategy],
    models: Mapping[str, Any],
    memories: Mapping[str, UpdaterState],
    frame: Frame,
    estimate: Ellipse,
) -> tuple[dict[str, Any], dict[str, UpdaterState]]:
    """Return models and memories after a frame in which the target is present at `estimate`."""
    learned, remembered = dict[str, Any](), dict(memories)
    for name, cue in cues.items():
        model = models[name]
        strategy = strategies.get(name)
        if strategy is not None and strategy.learns and isinstance(cue, AdaptableCue):
            seen = cue.observe(model, frame, estimate)
            if seen.any():
                histogram, memory = strategy.learn(
                    memories.get(name), model.histogram, model.anchor, seen
                )
                model = replace(model, histogram=histogram)
                if memory is not None:
                    remembered[name] = memory
        learned[name] = cue.update_reading(model, frame, estimate)
    return learned, remembered
