"""Where else may a target be? Particles that spread while it is missed, weighed by what it was.

Histograms of the target's colors (Nummiaro et al., section III) and edges (Ng and Delp, section
3.2) in its first region say where to look closer. Among 400 places anywhere in a frame they put
the target first far oftener than the posterior of single colors does, and they need no color.
How it is turned by now, the directions of its gradients say.
"""

from __future__ import annotations

import math

import msgspec
import numpy as np
from numpy.typing import NDArray

from motes.core.config import Config, NonNegative, Positive
from motes.core.frame import Frame
from motes.core.geometry import Ellipse
from motes.cues.color import Color, ColorModel
from motes.cues.edge_histogram import Edges, EdgesModel
from motes.cues.histogram_cue import bhattacharyya
from motes.cues.hog import Hog, HogModel
from motes.sot.filtering.resampling import Resampling, Weights

Floats = NDArray[np.float64]

MIN_HALF_AXIS = 2.0
"""Half-axis in pixels."""
RESTART_EVERY = 4
"""Of so many searchers one starts anew in each frame."""
DIRECTIONS = Hog(bins=16, rotation_normalized=False)
"""Of gradients, over a whole turn: a target that is turned has the same ones, all turned alike."""


class RedetectionModel(msgspec.Struct, frozen=True, eq=False, tag="looks"):
    """The histograms of the target's first region; those of directions, of a circle there."""

    color: ColorModel
    edges: EdgesModel
    directions: HogModel


class Redetection(Config, frozen=True):
    """A population of searchers.

    Attributes
    ----------
    color, edges
        The cues.
    edges_gain
        How much a distance of edges counts beside one of colors.
    sigma
        Searchers weigh exp(-distance / sigma).
    speed
        The target gets no farther than this many of its mean sides in a frame.
    growth
        Standard deviation of the logarithm of its size.
    turn_sigma
        Turns weigh exp(-distance / turn_sigma) of the directions that are seen to those turned so.
    """

    color: Color = Color()
    edges: Edges = Edges()
    edges_gain: NonNegative = 0.5
    sigma: Positive = 0.1
    speed: Positive = 0.5
    growth: NonNegative = 0.4
    turn_sigma: Positive = 0.03

    def learn(self, frame: Frame, ellipse: Ellipse) -> RedetectionModel:
        """Return the histograms of the region in `ellipse`."""
        return RedetectionModel(
            self.color.learn(frame, ellipse),
            self.edges.learn(frame, ellipse),
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
        """Move, weigh and select searchers.

        They walk by a quarter of their size, and some start anew within reach, in another size.

        Parameters
        ----------
        searchers
            (N, 5) the last frame's.
        last, missed
            Where the target was, and how many frames ago.

        Returns
        -------
        searchers, places
            The new ones, and where to look closer: at the likeliest of them; for there may be
            several alike, at one drawn by its weight; and at another one, as it seems to be turned.
        """
        ends = np.array([frame.width - 1, frame.height - 1])
        reach = self.speed * missed * 2 * math.sqrt(last.a * last.b)
        low, high = (np.clip(np.array(last[:2]) + way, 0, ends) for way in (-reach, reach))
        moved = searchers.copy()
        moved[:, :2] += rng.standard_normal((len(moved), 2)) * moved[:, 2:4] / 2
        fresh = moved[::RESTART_EVERY]
        fresh[:, :2] = low + rng.random((len(fresh), 2)) * (high - low)
        factors = np.exp(self.growth * rng.standard_normal((len(fresh), 1)))
        fresh[:, 2:4] = last[2:4] * np.clip(factors, *limits(last, frame))
        moved[:, :2] = np.clip(moved[:, :2], 0, ends)
        distances = self.color.distances(model.color, frame, moved)
        distances += self.edges_gain * self.edges.distances(model.edges, frame, moved)
        weights = Weights.from_log(-distances / self.sigma)
        chosen = moved[Resampling(scheme="systematic").ancestors(rng, weights, len(moved))]
        drawn = chosen[rng.integers(len(chosen), size=2)]
        drawn[1, 4] = self._turn(rng, model, frame, Ellipse(*drawn[1].tolist()))
        places = np.vstack([moved[int(np.argmin(distances))], drawn])
        return chosen, [Ellipse(*place) for place in places.tolist()]

    def _turn(
        self, rng: np.random.Generator, model: RedetectionModel, frame: Frame, place: Ellipse
    ) -> float:
        """Return by how much a target at a place may be turned since the start, in radians."""
        seen = DIRECTIONS.observe(model.directions, frame, circle(place))
        bins = len(seen)
        turned = np.stack([np.roll(model.directions.histogram, n) for n in range(bins)])
        weights = Weights.from_log(-bhattacharyya(turned, seen) / self.turn_sigma)
        return float(rng.choice(bins, p=weights.values) + rng.random() - 0.5) * 2 * math.pi / bins


def circle(ellipse: Ellipse) -> Ellipse:
    """Return the circle of an ellipse's area: its region stays the same when it is turned."""
    radius = math.sqrt(ellipse.a * ellipse.b)
    return Ellipse(ellipse.x, ellipse.y, radius, radius)


def limits(ellipse: Ellipse, frame: Frame) -> tuple[float, float]:
    """Return the factors by which a target may shrink, to `MIN_HALF_AXIS`, or grow to the frame."""
    half = np.array(ellipse[2:4])
    least = min(1.0, MIN_HALF_AXIS / half.min())
    most = max(1.0, (np.array([frame.width, frame.height]) / 2 / half).min())
    return float(least), float(most)
