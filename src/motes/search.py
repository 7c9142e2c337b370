"""Where else may a target be? Particles that spread while it is missed, weighed by what it was.

Histograms of the target's colors (Nummiaro et al., section III) and edges (Ng and Delp, section
3.2) in its first region say where to look closer. Among 400 places anywhere in a frame they put
the target first far oftener than the posterior of single colors does, and they need no color.
"""

from __future__ import annotations

import math

import msgspec
import numpy as np
from numpy.typing import NDArray

from motes.config import Config, NonNegative, Positive
from motes.cues.color import Color, ColorModel
from motes.cues.edges import Edges, EdgesModel
from motes.frame import Frame
from motes.geometry import Ellipse
from motes.resampling import Resampling, Weights

Floats = NDArray[np.float64]

SMALLEST = 2.0
"""Half-axis in pixels."""
FRESH = 4
"""Of so many searchers one starts anew in each frame."""


class LooksModel(msgspec.Struct, frozen=True, eq=False, tag="looks"):
    """The histograms of the target's first region."""

    color: ColorModel
    edges: EdgesModel


class Search(Config, frozen=True):
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
    turn
        Standard deviation of its turn in one frame, in radians; it grows with the root of time.
    """

    color: Color = Color()
    edges: Edges = Edges()
    edges_gain: NonNegative = 0.5
    sigma: Positive = 0.1
    speed: Positive = 0.5
    growth: NonNegative = 0.4
    turn: NonNegative = 1.0

    def learn(self, frame: Frame, ellipse: Ellipse) -> LooksModel:
        """Return the histograms of the region in `ellipse`."""
        return LooksModel(self.color.learn(frame, ellipse), self.edges.learn(frame, ellipse))

    def step(
        self,
        rng: np.random.Generator,
        model: LooksModel,
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
            several alike, at one drawn by its weight; and at another one, turned.
        """
        ends = np.array([frame.width - 1, frame.height - 1])
        reach = self.speed * missed * 2 * math.sqrt(last.a * last.b)
        low, high = (np.clip(np.array(last[:2]) + way, 0, ends) for way in (-reach, reach))
        moved = searchers.copy()
        moved[:, :2] += rng.standard_normal((len(moved), 2)) * moved[:, 2:4] / 2
        fresh = moved[::FRESH]
        fresh[:, :2] = low + rng.random((len(fresh), 2)) * (high - low)
        factors = np.exp(self.growth * rng.standard_normal((len(fresh), 1)))
        fresh[:, 2:4] = last[2:4] * np.clip(factors, *limits(last, frame))
        moved[:, :2] = np.clip(moved[:, :2], 0, ends)
        distances = self.color.distances(model.color, frame, moved)
        distances += self.edges_gain * self.edges.distances(model.edges, frame, moved)
        weights = Weights.from_log(-distances / self.sigma)
        chosen = moved[Resampling(scheme="systematic").ancestors(rng, weights, len(moved))]
        drawn = chosen[rng.integers(len(chosen), size=2)]
        drawn[1, 4] += self.turn * math.sqrt(missed) * rng.standard_normal()
        places = np.vstack([moved[int(np.argmin(distances))], drawn])
        return chosen, [Ellipse(*place) for place in places.tolist()]


def limits(ellipse: Ellipse, frame: Frame) -> tuple[float, float]:
    """Return the factors by which a target may shrink and grow: to `SMALLEST`, and to the frame."""
    half = np.array(ellipse[2:4])
    least = min(1.0, SMALLEST / half.min())
    most = max(1.0, (np.array([frame.width, frame.height]) / 2 / half).min())
    return float(least), float(most)
