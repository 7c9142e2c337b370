"""Whether what is followed is the target or a neighbor: a belief.

The evidence of a place (`expert.py`) says that something like the target is there; in a crowd it
may be somebody else. So looks of what moves beside the target are kept, and what is followed is
compared with them and with the target as it was. The belief is a logistic regression on the running
mean of what the frames say: they repeat each other, so that their log odds do not add up. Twins
are one as likely as the other. The belief only judges: it moves nothing, and decides nothing of
what the tracker learns.
"""

from __future__ import annotations

import math
from typing import Annotated, Self

import msgspec
import numpy as np
from msgspec import Meta
from msgspec.structs import replace

from motes.core.frame import Frame
from motes.core.geometry import Ellipse
from motes.core.types import Floats, Singles, median
from motes.cues.color import Color
from motes.cues.sampling import Lattice
from motes.cues.search_window import CELL_SIZE, SampleGrid
from motes.sot.discriminative.exclusion import BESIDE
from motes.sot.discriminative.expert import probability

GAIN = 16.0
"""Log odds for a lead of 1. In crowds it is 0.12 on the mean, and -0.13 on somebody else."""
SHARE = 0.1
"""Share of a frame in the lead: some seven frames on somebody else change the belief."""
EVERY = 4
"""Frames between two searches for a neighbor: a walker has moved by some pixels then. The target's
known looks are as many searches old, so that an exchange is noticed before it is learned."""
MEMORY = 8
"""Number of looks that are kept of the neighbors, and as many of the target: of one that is known
by more looks, one is nearer by chance."""
ALONE = 4.0
"""A neighbor moves where the change of the picture is this many times its median around the target.
Before a moving camera all of it changes, and the median with it."""
INNER = 0.6
"""Share of the width in which colors are read; beside it there is much background."""
COLOR = Color(kernel="epanechnikov", sampling=Lattice(points=256))
"""Read in the upper and in the lower half: a half alone tells a shirt from trousers."""
CELLS, CELL = 8, 2
"""Cells to a side of the target: its neighbors are placed to an eighth of it. Samples to a side of
a cell, whose four `grays` adds up."""
SIDE = CELLS * CELL
WINDOW = SampleGrid(5 * SIDE // CELL_SIZE, 5 * SIDE // CELL_SIZE, SIDE, SIDE)
"""Where a neighbor is looked for: five sides, as in the confined filter's window."""
STEPS = CELL * np.arange(-2.0 * CELLS, 2.0 * CELLS + 1)
PLACES = np.stack(np.meshgrid(STEPS, STEPS), axis=-1).reshape(-1, 2)
"""(n, 2), the centers of the boxes of the target's size in the window, in samples from its own."""


class Belief(msgspec.Struct, frozen=True, eq=False):
    """The belief after a frame, and the looks that it follows from (`look_at`)."""

    first: Singles
    """(m,), the target's first look."""
    known: Singles
    """(MEMORY, m), the target when it was believed to be followed, the newest last."""
    recent: Singles
    """(EVERY, m), what was followed since then, the newest last."""
    neighbors: Singles
    """(MEMORY, m), the newest last; zero where there is none yet."""
    place: Ellipse
    """The target when neighbors were last looked for."""
    grays: Singles
    """(h, w), the picture around it at that time."""
    shift: Floats
    """(2,), the shift of the scene since then, in pixels."""
    lead: Annotated[float, Meta(ge=-1, le=1)] = 1.0
    """Running mean of how much nearer what is followed looks to the target than to the neighbors:
    of the difference of both distances. Nobody is known at first."""
    distance: Annotated[float, Meta(ge=0)] = 0.0
    """Distance of what is followed to the nearest look of the target, where it was last seen."""
    frames: Annotated[int, Meta(ge=0)] = 0
    """Number of frames since the target was placed."""

    @property
    def probability(self) -> float:
        """The probability that what is followed is the target."""
        return probability(GAIN * self.lead)

    @classmethod
    def begin(cls, frame: Frame, box: Ellipse) -> Self:
        """Return the belief in the first frame, with the target in `box`."""
        look = look_at(frame, box)
        nobody = np.zeros((MEMORY, len(look)), np.float32)
        known, recent = np.tile(look, (MEMORY, 1)), np.tile(look, (EVERY, 1))
        return cls(look, known, recent, nobody, box, grays(frame, box), np.zeros(2))

    def placed(self, frame: Frame, box: Ellipse) -> Self:
        """Return the belief where the user has placed the target; neighbors are still known."""
        return replace(self.begin(frame, box), first=self.first, neighbors=self.neighbors)

    def learned_also(self, frame: Frame, box: Ellipse) -> Self:
        """Return the belief about a target that also looks as in another frame."""
        look = look_at(frame, box)
        known = np.vstack([self.known[1:], look])
        return replace(self, known=known, recent=np.tile(look, (EVERY, 1)))

    def after(self, frame: Frame, target: Ellipse, camera: Floats, *, seen: bool) -> Self:
        """Return the belief after a frame.

        `camera` (2,) is the shift of the scene since the last frame, in pixels. Unless something
        like the target is seen, nothing is known about who it is.
        """
        look, lead, distance = look_at(frame, target), self.lead, self.distance
        if seen:
            own = distances(np.vstack([self.first, self.known]), look).min()
            difference = float(distances(self.neighbors, look).min() - own)
            lead, distance = lead + SHARE * (difference - lead), float(own)
        shift, frames = self.shift + camera, self.frames + 1
        after = replace(self, lead=lead, distance=distance, shift=shift, frames=frames)
        return after if after.frames % EVERY else after._kept(frame, target, look, seen)

    def _kept(self, frame: Frame, target: Ellipse, look: Singles, seen: bool) -> Self:
        """Return the belief with the looks of this frame, if the target is believed to be there."""
        now = replace(self, place=target, grays=grays(frame, target), shift=np.zeros(2))
        if not seen or self.probability < 0.5:  # neither it nor what is beside it is to be kept
            return replace(now, recent=np.tile(self.known[-1], (EVERY, 1)))
        neighbor, neighbors = self._neighbor(frame, target), self.neighbors
        if neighbor is not None:
            neighbors = np.vstack([neighbors[1:], look_at(frame, neighbor)])
        known = np.vstack([self.known[1:], self.recent[0]])
        recent = np.vstack([self.recent[1:], look])
        return replace(now, known=known, recent=recent, neighbors=neighbors)

    def _neighbor(self, frame: Frame, target: Ellipse) -> Ellipse | None:
        """Return where most changes beside the target, or None if nothing moves there.

        It may be what the target has just left: somebody who comes close behind is there.
        """
        x, y = np.add(self.place[:2], self.shift).tolist()
        still, moved = self.place, self.place._replace(x=x, y=y)  # the shift may be wrong
        changes = [(np.abs(grays(frame, each) - self.grays), each) for each in (moved, still)]
        change, place = min(changes, key=lambda each: float(each[0].sum()))
        sums = np.pad(change, ((1, 0), (1, 0))).cumsum(axis=0).cumsum(axis=1)
        down = sums[CELLS:] - sums[:-CELLS]
        changed = (down[:, CELLS:] - down[:, :-CELLS]).ravel()
        own = WINDOW.offsets(place, np.array(target[:2]))
        common = np.maximum(1 - np.abs(PLACES - own) / SIDE, 0).prod(axis=1)
        beside = np.where(common / (2 - common) < BESIDE, changed, 0)
        best = int(beside.argmax())
        x, y = WINDOW.points(place, PLACES[best]).tolist()
        inside = 0 <= x < frame.width and 0 <= y < frame.height
        if not inside or beside[best] <= ALONE * median(changed):
            return None
        return target._replace(x=x, y=y)


def look_at(frame: Frame, ellipse: Ellipse) -> Singles:
    """Return how a place looks, (m,): the roots of the histograms of its upper and lower half."""
    x, y, a, b, theta = ellipse
    right, down = -math.sin(theta) * b / 2, math.cos(theta) * b / 2
    halves = [(x - right, y - down), (x + right, y + down)]
    regions = np.array([(*center, INNER * a, b / 2, theta) for center in halves])
    return np.sqrt(COLOR.histograms(frame, regions).ravel() / 2).astype(np.float32)


def distances(looks: Singles, look: Singles) -> Singles:
    """Return the Bhattacharyya distances of looks (n, m) to one (m,), (n,); 1 of a zero one."""
    out: Singles = np.sqrt(np.maximum(1 - looks @ look, 0))
    return out


def grays(frame: Frame, place: Ellipse) -> Singles:
    """Return the sums of red, green and blue in the cells of the window around a place."""
    samples = WINDOW.sample_window(frame, place).sum(axis=0)
    pairs = samples[:, ::2] + samples[:, 1::2]
    out: Singles = pairs[::2] + pairs[1::2]
    return out
