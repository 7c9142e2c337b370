"""The experts of the default tracker: their interface, their names, and all of them together.

Experts differ in kind, and each learns the target in its own way. Each can say where it sees the
target, and how much a place speaks for or against it. No expert is judge in its own case: what
counts of a place is the sum of all log odds, as in a logistic regression. No voice can veto the
others: a gray target has no color contrast, a turned one no likeness to the first frame, and either
may still be known by the rest.
"""

from __future__ import annotations

import math
from abc import abstractmethod
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from motes.core.config import Config, NonNegative
from motes.core.frame import Frame
from motes.core.geometry import Ellipse
from motes.core.registry import Registry
from motes.core.types import check_finite
from motes.cues.confined_filter import ConfinedFilter, ConfinedModel, ConfinedView

NEUTRAL = 0.6
"""A filter's response that speaks neither for a place nor against it."""
LARGEST_LOG_ODDS = 30.0


class Evidence(Config, frozen=True):
    """The log odds that the target is at a place: those of the near window, and of a prior.

    The other experts add theirs. All weights were fitted by logistic regression to places on the
    target and beside it, half of these places where a tracker had been led astray. They are the
    same for all videos. With a weight of 0, a voice has no say.
    """

    gradients: NonNegative = 5.0
    """Weight of the response of the first frame's correlation filter, which never learns."""
    contrast: NonNegative = 5.0
    """Weight of the color contrast between the box and its surroundings, -1 to 1."""
    prior: float = -2.0
    """Log odds of a place of which no expert says anything."""

    def log_odds(self, gradients: float, contrast: float) -> float:
        """Return the log odds of a place with this response and this contrast."""
        return self.prior + self.gradients * gradients + self.contrast * contrast


def probability(log_odds: float) -> float:
    """Return the probability of log odds, from 0 to 1."""
    return 1 / (1 + math.exp(-min(max(log_odds, -LARGEST_LOG_ODDS), LARGEST_LOG_ODDS)))


class Expert:
    """The interface of an expert.

    An expert is also a `Config`: `class Flow(Expert, Config, frozen=True)`. Its model of the target
    is any frozen `msgspec.Struct`, and its sight of a frame any object; only the expert itself
    reads them. Methods change neither, nor the frame.
    """

    __slots__ = ()

    @abstractmethod
    def learn(self, frame: Frame, box: Ellipse) -> Any:
        """Return the model of the target in the ellipse `box`."""

    @abstractmethod
    def look(self, model: Any, frame: Frame, place: Ellipse) -> Any:
        """Return the expert's sight of a frame around a place."""

    @abstractmethod
    def log_odds(self, sight: Any, place: Ellipse) -> float:
        """Return by how much the sight speaks for a place: 0 is neither for it nor against it."""

    def serves(self, sight: Any, place: Ellipse) -> bool:
        """Return whether a sight can judge a place. If not, the expert looks there again."""
        return True

    def proposes(self, sight: Any) -> Ellipse | None:
        """Return where the expert sees the target, or None."""
        return None

    def updated(self, model: Any, frame: Frame, sight: Any, place: Ellipse, share: float) -> Any:
        """Return the model after a frame with the target at `place`; by default it stays.

        `share` is how much of the frame is learned, from 0 to 1: nothing where the place is in
        doubt.
        """
        return model

    def learn_also(self, model: Any, frame: Frame, box: Ellipse) -> Any:
        """Return the model of a target that also looks as in another frame; by default it stays."""
        return model

    def placed(self, model: Any, box: Ellipse) -> Any:
        """Return the model of a target that the user has placed; by default it stays."""
        return model


EXPERTS = Registry[type[Expert]](
    "expert",
    "motes.experts",
    Expert,
    {
        "confined": "motes.sot.discriminative.expert:Confined",
        "backdrop": "motes.sot.discriminative.backdrop:Backdrop",
    },
    tagged=False,
)


@dataclass(frozen=True, slots=True)
class Experts:
    """The experts in use, asked together; models and sights are by the experts' names."""

    named: Mapping[str, Expert]

    def learn(self, frame: Frame, box: Ellipse) -> dict[str, Any]:
        """Return the models of the target in `box`."""
        return {name: expert.learn(frame, box) for name, expert in self.named.items()}

    def look(self, models: Mapping[str, Any], frame: Frame, place: Ellipse) -> dict[str, Any]:
        """Return the sights of a frame, looked at around `place`."""
        return {
            name: expert.look(models[name], frame, place) for name, expert in self.named.items()
        }

    def look_again(
        self, models: Mapping[str, Any], frame: Frame, place: Ellipse, sights: Mapping[str, Any]
    ) -> dict[str, Any]:
        """Return sights that can judge a place: those given, or new ones around it."""
        return {
            name: sights[name]
            if expert.serves(sights[name], place)
            else expert.look(models[name], frame, place)
            for name, expert in self.named.items()
        }

    def proposals(self, sights: Mapping[str, Any]) -> list[Ellipse]:
        """Return where the experts see the target."""
        places = {name: expert.proposes(sights[name]) for name, expert in self.named.items()}
        seen = {name: place for name, place in places.items() if place is not None}
        for name, place in seen.items():
            check_finite(place, "expert", name)
        return list(seen.values())

    def log_odds(self, sights: Mapping[str, Any], place: Ellipse) -> float:
        """Return by how much the experts together speak for a place."""
        total = 0.0
        for name, expert in self.named.items():
            voice = float(expert.log_odds(sights[name], place))  # `>` of NumPy's gives no `True`
            check_finite(voice, "expert", name)
            total += voice
        return total

    def updated(
        self,
        models: Mapping[str, Any],
        frame: Frame,
        sights: Mapping[str, Any],
        place: Ellipse,
        share: float,
    ) -> dict[str, Any]:
        """Return the models after a frame with the target at `place`; see `Expert.updated`."""
        return {
            name: expert.updated(models[name], frame, sights[name], place, share)
            for name, expert in self.named.items()
        }

    def learn_also(self, models: Mapping[str, Any], frame: Frame, box: Ellipse) -> dict[str, Any]:
        """Return the models of a target that also looks as in another frame."""
        return {
            name: expert.learn_also(models[name], frame, box) for name, expert in self.named.items()
        }

    def placed(self, models: Mapping[str, Any], box: Ellipse) -> dict[str, Any]:
        """Return the models of a target that the user has placed."""
        return {name: expert.placed(models[name], box) for name, expert in self.named.items()}


class Confined(ConfinedFilter, Expert, frozen=True):
    """The response of a filter that is confined to the target; see `ConfinedFilter`."""

    weight: NonNegative = 2.5
    """Log odds for a place with the response of the first frames; see `Evidence`. With 0 the expert
    is not asked."""

    def look(self, model: ConfinedModel, frame: Frame, place: Ellipse) -> ConfinedView:
        """Return the responses around a place."""
        return self.view(model, frame, place)

    def serves(self, sight: ConfinedView, place: Ellipse) -> bool:
        """Return whether the window holds the place, in about its size and in its angle."""
        return sight.covers(place)

    def proposes(self, sight: ConfinedView) -> Ellipse:
        """Return where the response is largest."""
        return sight.peak()

    def log_odds(self, sight: ConfinedView, place: Ellipse) -> float:
        """Return by how much the response speaks for a place."""
        return self.weight * (sight.near(place) - NEUTRAL)
