"""How an object looks where nothing covers it, and how likely two looks are those of one object."""

from __future__ import annotations

import math
from collections.abc import Sequence

import msgspec
import numpy as np

from motes.core.frame import Frame
from motes.core.geometry import Ellipse
from motes.core.types import Floats
from motes.cues.color import Color
from motes.cues.gradients import Hog
from motes.cues.sampling import Lattice

COLOR = Color(space="hsv", bins=(8, 8, 4), kernel="epanechnikov", sampling=Lattice(points=256))
"""Of the upper and of the lower half; a half alone tells a shirt from trousers."""
EDGES = Hog(cells=3, rotation_normalized=False, sampling=Lattice(points=256))
"""The 72 bins by which Zhao and Pei, section 3, distinguish targets of one color."""
INNER = 0.6
"""Share of the width in which colors are read; beside it there is much background."""
BESIDE = 1 + INNER
"""How far off the centers of the strips at both sides are, in half-widths: they touch the box."""
FRAMES = 5
"""Frames from which a look is: a mean over the first ones, then it follows at this rate."""
COLOR_WEIGHT, EDGES_WEIGHT = 20.0, 7.0
"""Change of the logarithm of the likelihood that two looks are those of one object, for a distance.

Color distances of one person before and after an occlusion are 0.49 ± 0.13, those of two people of
one group 0.81 ± 0.10; edge distances 0.31 and 0.36 ± 0.06. The ratio of two such densities is
linear, with a slope of the means' difference over the variance."""
UNKNOWN = 15.0
"""Cost of an object whose look is not known: halfway between one object and two."""
ALIKE, DIFFERENT = 0.4, 0.6
"""Mean color distance of the objects of a scene, up to which their looks tell nothing, and from
which on all: that of walkers is 0.75, that of fish of one kind 0.2."""
COMPARED = 64
"""Most objects of which that is found."""


class Look(msgspec.Struct, frozen=True, eq=False):
    """A mean look over some frames."""

    color: Floats
    """(512,), the histograms of both halves."""
    edges: Floats
    """(72,)."""
    frames: int = 1
    """How many frames it has been seen in."""

    @property
    def settled(self) -> bool:
        """Whether it is a mean over enough frames; a single one may be blurred, or of a part."""
        return self.frames >= FRAMES

    @classmethod
    def at(cls, frame: Frame, ellipses: Sequence[Ellipse]) -> list[Look]:
        """Return the looks of upright ellipses in a frame.

        The colors are those of which more is in an ellipse than beside it. The rest may be
        background, which is another one after an occlusion.
        """
        if not ellipses:
            return []
        whole = np.array(ellipses)
        inside, left, right = _halves(frame, whole)
        own = np.maximum(inside - (left + right) / 2, 0)
        total = own.sum(axis=2, keepdims=True)
        colors = np.divide(own, 2 * total, out=np.zeros_like(own), where=total > 0)
        edges = EDGES.histograms(frame, whole)
        return [cls(*each) for each in zip(colors.reshape(len(whole), -1), edges, strict=True)]

    def joined(self, before: Look | None) -> Look:
        """Return this look of a frame together with the look so far."""
        if before is None:
            return self
        share = 1 / min(before.frames + 1, FRAMES)
        color = before.color + share * (self.color - before.color)
        edges = before.edges + share * (self.edges - before.edges)
        return Look(color, edges, before.frames + 1)


def _halves(frame: Frame, whole: Floats) -> Floats:
    """Return the colors of both halves of ellipses (n, 5), and of the strips at both sides.

    The shape is (3, n, 2, m).
    """
    halves = np.tile(np.repeat(whole, 2, axis=0) * (1, 1, INNER, 0.5, 1), (3, 1, 1))
    halves[1:, :, 0] += np.array([[-BESIDE], [BESIDE]]) * np.repeat(whole[:, 2], 2)
    halves[:, ::2, 1] -= halves[:, ::2, 3]
    halves[:, 1::2, 1] += halves[:, 1::2, 3]
    return COLOR.histograms(frame, halves.reshape(-1, 5)).reshape(3, len(whole), 2, -1)


def telling(looks: Sequence[Look]) -> float:
    """Return how much a look tells of who it is, from 0 to 1, if these are those of the scene.

    Where all look alike, differences are those of one object from frame to frame.
    """
    colors = [each.color for each in looks[:COMPARED]]
    if len(colors) < 2:
        return 1.0
    mean = _distances(colors, colors).sum() / (len(colors) * (len(colors) - 1))
    return float(np.clip((mean - ALIKE) / (DIFFERENT - ALIKE), 0, 1))


def costs(seen: Sequence[Look], known: Sequence[Look | None], tells: float = 1.0) -> Floats:
    """Return how unlikely each look that is seen is that of each known one: (seen, known).

    These are negative logarithms of likelihoods, but for a constant; they are the nearer to
    `UNKNOWN`, the less looks tell.
    """
    told = [k for k, each in enumerate(known) if each is not None]
    models = [each for each in known if each is not None]
    out = np.full((len(seen), len(known)), UNKNOWN)
    unlike = COLOR_WEIGHT * _distances(
        [each.color for each in seen], [each.color for each in models]
    ) + EDGES_WEIGHT * _distances([each.edges for each in seen], [each.edges for each in models])
    out[:, told] += tells * (unlike - UNKNOWN)
    return out


def probability_of_one(cost: float) -> float:
    """Return the probability that a cost is that of one object, not of two, one as likely."""
    return 1 / (1 + math.exp(cost - UNKNOWN))


def _distances(some: Sequence[Floats], others: Sequence[Floats]) -> Floats:
    """Return the Bhattacharyya distances of histograms: (some, others); 1 of an empty one."""
    if not others:
        return np.zeros((len(some), 0))
    distances: Floats = np.sqrt(np.maximum(0, 1 - np.sqrt(some) @ np.sqrt(others).T))
    return distances
