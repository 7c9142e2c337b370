"""The search for a missed target: particles that spread farther in each frame.

The particles are weighted by the color histogram (Nummiaro et al., section III) and the edge
histogram (Ng and Delp, section 3.2) of the target's first region. Among 400 places in a frame,
these rank the target first far more often than the color posterior does, and they also work
without color. The histogram of gradient directions shows by how much the target is turned.

The same histograms have a voice about what the search finds, and about a rival that is to take the
target's place. While the target is followed from frame to frame they have none, since it may be
half hidden or in another light.
"""

from __future__ import annotations

import math
from typing import Annotated

import msgspec
import numpy as np
from msgspec import Meta
from msgspec.structs import replace

from motes.core.config import Config, NonNegative, Positive
from motes.core.frame import Frame
from motes.core.geometry import Ellipse
from motes.core.types import Floats
from motes.cues.base import HistogramModel, bhattacharyya
from motes.cues.color import Color, ColorModel
from motes.cues.gradients import Edges, Hog
from motes.sot.filtering.resampling import Systematic, Weights

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

        Each moves by noise, with a deviation of a quarter of its size. Some restart anywhere within
        reach, with another size.

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
        fresh = moved[::RESTART_EVERY]  # a view: these restart in place
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
        """Return the log odds against a place that is less like the first region than usual.

        They are the logarithm of the weight of a search particle there, beside that of the target
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
