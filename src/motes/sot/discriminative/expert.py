"""The experts of the default tracker: their interface, their names, all of them, and the search.

Experts differ in kind, and each learns the target in its own way. Each can say where it sees the
target, and how much a place speaks for or against it. No expert is judge in its own case: what
counts of a place is the sum of all log odds, as in a logistic regression. No voice can veto the
others: a gray target has no color contrast, a turned one no likeness to the first frame, and either
may still be known by the rest.

A missed target is searched for with particles that spread farther in each frame. They are
weighted by the color histogram (Nummiaro et al., section III) and the edge
histogram (Ng and Delp, section 3.2) of the target's first region. Among 400 places in a frame,
these rank the target first far more often than the color posterior does, and they also work
without color. The histogram of gradient directions shows by how much the target is turned.

The same histograms have a voice about what the search finds. While the target is followed from
frame to frame they have none, since it may be half hidden or in another light.
"""

from __future__ import annotations

import math
from abc import abstractmethod
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Annotated, Any

import msgspec
import numpy as np
from msgspec import Meta
from msgspec.structs import replace

from motes.core.config import Config, NonNegative, Positive
from motes.core.frame import Frame
from motes.core.geometry import Ellipse
from motes.core.registry import Registry
from motes.core.types import Floats
from motes.cues.base import HistogramModel, bhattacharyya
from motes.cues.color import Color, ColorModel
from motes.cues.confined_filter import ConfinedFilter, ConfinedModel, ConfinedView
from motes.cues.gradients import Edges, Hog
from motes.sot.discriminative.identity import APART
from motes.sot.filtering.resampling import Systematic, Weights

NEUTRAL = 0.6
"""A filter's response that speaks neither for a place nor against it."""


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

    def refined(self, sight: Any, place: Ellipse) -> Ellipse | None:
        """Return where the expert sees the target near a place, or None if it does not."""
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
    {"confined": "motes.sot.discriminative.expert:Confined"},
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
        self,
        models: Mapping[str, Any],
        frame: Frame,
        place: Ellipse,
        sights: Mapping[str, Any],
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
        places = [expert.proposes(sights[name]) for name, expert in self.named.items()]
        return [place for place in places if place is not None]

    def refined(self, sights: Mapping[str, Any], place: Ellipse) -> Ellipse:
        """Return the mean of a place and of where the experts see the target near it."""
        near = [expert.refined(sights[name], place) for name, expert in self.named.items()]
        seen = [place, *(each for each in near if each is not None)]
        x, y = (sum(each[axis] for each in seen) / len(seen) for axis in (0, 1))
        return place._replace(x=x, y=y)

    def log_odds(self, sights: Mapping[str, Any], place: Ellipse) -> float:
        """Return by how much the experts together speak for a place."""
        voices = (expert.log_odds(sights[name], place) for name, expert in self.named.items())
        return float(sum(voices))  # of a NumPy number, `>` gives a value that is no `True`

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


TRUSTED_RESPONSE = NEUTRAL / 2
"""From this response on, relative to the first frames, the filter's place counts."""


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

    def refined(self, sight: ConfinedView, place: Ellipse) -> Ellipse | None:
        """Return where the response is largest among the places that may be the same target."""
        response, peak = sight.near(place, APART)
        return peak if response > TRUSTED_RESPONSE else None

    def log_odds(self, sight: ConfinedView, place: Ellipse) -> float:
        """Return by how much the response speaks for a place."""
        response, _ = sight.near(place)
        return self.weight * (response - NEUTRAL)


SYSTEMATIC = Systematic()
"""How particles are selected, also those of place and size."""
MIN_HALF_AXIS = 2.0
"""Smallest half-axis that the search tries, in pixels."""
PLACES = 5
"""Places that a frame's search proposes: in a first look a target is missed more often than not."""
RESTART_EVERY = 4
"""One of this many search particles restarts in each frame."""
COLOR, EDGES = Color(), Edges()
"""The histograms of colors and of edges, as the papers have them."""
DIRECTIONS = Hog(bins=16, rotation_normalized=False)
"""Histogram of gradient directions over a full turn; a turned target has a shifted histogram."""


class RedetectionModel(msgspec.Struct, frozen=True, eq=False, tag="looks"):
    """The histograms of the target's first region; for the directions, of a circle of its area."""

    color: ColorModel
    edges: HistogramModel
    directions: HistogramModel
    usual: Annotated[float, Meta(ge=0)] = 0.0
    """Running mean of the target's distance, by color and edges, while it was tracked."""
    seen: Annotated[int, Meta(ge=0)] = 0
    """Number of frames in this mean."""


class Redetection(Config, frozen=True):
    """The search for a missed target by particles."""

    sigma: Positive = 0.1
    """The weight of a particle is exp(-distance / sigma), and so is that of an angle, with the
    distance between the directions in the frame and those of the model turned by it."""
    speed: Positive = 0.5
    """The largest distance that the target moves in a frame, in mean sides of the target."""
    growth: NonNegative = 0.4
    """Standard deviation of the logarithm of the size of a particle that starts anew. With a larger
    value, more sizes are searched."""

    def learn(self, frame: Frame, ellipse: Ellipse) -> RedetectionModel:
        """Return the histograms of the region in `ellipse`."""
        return RedetectionModel(
            COLOR.learn(frame, ellipse),
            EDGES.learn(frame, ellipse),
            DIRECTIONS.learn(frame, circle(ellipse)),
        )

    def step(
        self,
        rng: np.random.Generator,
        model: RedetectionModel,
        searchers: Floats,
        frame: Frame,
        last: Ellipse,
        missed: int,
    ) -> tuple[Floats, list[Ellipse]]:
        """Move, weight and resample the search particles.

        Each moves by a quarter of its size. Some restart anywhere within reach, with another size.

        Parameters
        ----------
        searchers
            (N, 5) the particles after the last frame.
        last, missed
            Where the target was last, and the number of frames since then.

        Returns
        -------
        searchers, places
            The new particles, and `PLACES` for a localization: the most likely particle, and others
            drawn by weight, the last of them turned as its directions suggest.
        """
        ends = np.array([frame.width - 1, frame.height - 1])
        reach = self.speed * missed * last.side
        low, high = (np.clip(np.array(last[:2]) + way, 0, ends) for way in (-reach, reach))
        moved = searchers.copy()
        moved[:, :2] += rng.standard_normal((len(moved), 2)) * moved[:, 2:4] / 2
        fresh = moved[::RESTART_EVERY]
        fresh[:, :2] = low + rng.random((len(fresh), 2)) * (high - low)
        factors = np.exp(self.growth * rng.standard_normal((len(fresh), 1)))
        fresh[:, 2:4] = last[2:4] * np.clip(factors, *limits(last, frame))
        moved[:, :2] = np.clip(moved[:, :2], 0, ends)
        distances = self._distances(model, frame, moved)
        weights = Weights.from_log(-distances / self.sigma)
        chosen = moved[SYSTEMATIC.ancestors(rng, weights, len(moved))]
        drawn = chosen[rng.integers(len(chosen), size=PLACES - 1)]
        drawn[-1, 4] = self._turn(rng, model, frame, Ellipse(*drawn[-1].tolist()))
        places = np.vstack([moved[int(np.argmin(distances))], drawn])
        return chosen, [Ellipse(*place) for place in places.tolist()]

    def log_odds(self, model: RedetectionModel, frame: Frame, place: Ellipse) -> float:
        """Return by how much a place that is less like the first region than usual is not it.

        It is the logarithm of the weight of a search particle there, beside that of the target
        as it usually is; 0 where the place is as like as that.
        """
        distance = float(self._distances(model, frame, np.array([place]))[0])
        return min((model.usual - distance) / self.sigma, 0.0)

    def updated(
        self, model: RedetectionModel, frame: Frame, ellipse: Ellipse, rate: float
    ) -> RedetectionModel:
        """Return the model after a frame with the target in `ellipse`; the histograms stay.

        The frame has the weight `rate` in the usual distance, and more while few were seen.
        """
        distance = float(self._distances(model, frame, np.array([ellipse]))[0])
        seen = model.seen + 1
        usual = model.usual + max(rate, 1 / seen) * (distance - model.usual)
        return replace(model, usual=usual, seen=seen)

    def _distances(self, model: RedetectionModel, frame: Frame, ellipses: Floats) -> Floats:
        """Return the distances of ellipses (N, 5) to the first region, (N,)."""
        colors = COLOR.distances(model.color, frame, ellipses)
        return colors + EDGES.distances(model.edges, frame, ellipses)

    def _turn(
        self, rng: np.random.Generator, model: RedetectionModel, frame: Frame, place: Ellipse
    ) -> float:
        """Return an angle by which the target may be turned since the start, in radians."""
        seen = DIRECTIONS.observe(model.directions, frame, circle(place))
        bins = len(seen)
        turned = np.stack([np.roll(model.directions.histogram, n) for n in range(bins)])
        weights = Weights.from_log(-bhattacharyya(turned, seen) / self.sigma)
        return float(rng.choice(bins, p=weights.values) + rng.random() - 0.5) * 2 * math.pi / bins


def circle(ellipse: Ellipse) -> Ellipse:
    """Return the circle with the area of an ellipse; turning does not change its region."""
    radius = math.sqrt(ellipse.a * ellipse.b)
    return Ellipse(ellipse.x, ellipse.y, radius, radius)


def limits(ellipse: Ellipse, frame: Frame) -> tuple[float, float]:
    """Return the smallest and largest size factor: down to `MIN_HALF_AXIS`, up to the frame."""
    half = np.array(ellipse[2:4])
    least = min(1.0, MIN_HALF_AXIS / half.min())
    most = max(1.0, (np.array([frame.width, frame.height]) / 2 / half).min())
    return float(least), float(most)
