"""An expert for what is not the target: the backdrop, which was there before it came.

A target that has moved covers what was seen there before. Where a place looks as it did while the
target was elsewhere, the target is not there: what is followed is the post, the sign or the bush
behind which it went, and which the models have learned bit by bit. So pictures of the last frames
are kept, each with the place of the target. What lies around a place is looked for in them, as the
camera may have moved; then what is inside is compared. A target that rests has no backdrop: its
place was never seen without it.
"""

from __future__ import annotations

import math
from typing import NamedTuple, Self

import msgspec
import numpy as np

from motes import kernels
from motes.core.config import Config, NonNegative
from motes.core.frame import Frame
from motes.core.geometry import Ellipse, iou
from motes.core.types import Singles, correlation
from motes.cues.search_window import cut
from motes.sot.discriminative.exclusion import BESIDE
from motes.sot.discriminative.expert import Expert

EVERY = 6
"""Frames from one picture to the next: few targets leave their place in fewer."""
MEMORY = 4
"""Number of pictures."""
POINTS = 10
"""Points of a picture to a mean side of the target, as long as it has no more than `MOST`."""
MOST = 320
"""Most points to the longer side of a picture."""
AROUND = 2.5
"""Sides of the surroundings of a place, in sides of the place."""
REACH = 1.5
"""How far the scene may have moved in the picture, in mean sides of the target."""
ALIKE = 0.7
"""Correlation from which on two pictures show the same: less is found between a target and its
backdrop by chance."""
LEAST = 3
"""Points to a side of a place that can be compared."""


class Points(NamedTuple):
    """The points of a picture in a rectangle: the first column and row, and those behind it."""

    left: int
    top: int
    right: int
    bottom: int

    def of(self, picture: Singles, x: int, y: int) -> Singles:
        """Return the points of a picture that begins at a column and a row."""
        return picture[self.top - y : self.bottom - y, self.left - x : self.right - x]


class Snapshot(msgspec.Struct, frozen=True, eq=False):
    """A picture of a frame, and where the target was in it."""

    grays: Singles
    """(h, w), the sums of red, green and blue at points that are `pitch` apart."""
    pitch: float
    """Pixels from one point to the next."""
    target: Ellipse

    @classmethod
    def of(cls, frame: Frame, target: Ellipse) -> Self:
        """Return the picture of a frame; the larger the target, the coarser it is."""
        pitch = max(target.side / POINTS, max(frame.width, frame.height) / MOST)
        columns, rows = (int((side - 1) / pitch) + 1 for side in (frame.width, frame.height))
        every = Points(0, 0, columns, rows)
        return cls(gray_points(frame, every, pitch), pitch, target)

    def points(self, place: Ellipse, sides: float) -> Points:
        """Return the points of a place with `sides` times its sides, as far as there are any."""
        rows, columns = self.grays.shape
        _, _, width, height = place.box
        x, y = place.x / self.pitch, place.y / self.pitch
        across, down = sides * width / 2 / self.pitch, sides * height / 2 / self.pitch
        left, top = max(math.ceil(x - across), 0), max(math.ceil(y - down), 0)
        right, bottom = (
            min(math.floor(x + across) + 1, columns),
            min(math.floor(y + down) + 1, rows),
        )
        return Points(left, top, max(right, left), max(bottom, top))

    def likeness(self, frame: Frame, place: Ellipse) -> float | None:
        """Return the correlation of a place in a frame with what was there without the target.

        0 if the target was there, and None if its surroundings are not found in the picture.
        """
        around, core = self.points(place, AROUND), self.points(place, 1.0)
        left, top, *_ = around
        if around == core or min(core.right - core.left, core.bottom - core.top) < LEAST:
            return None  # nothing is around a target that fills the picture
        now = gray_points(frame, around, self.pitch)
        reach = round(REACH * place.side / self.pitch)
        first_x, first_y = max(left - reach, 0), max(top - reach, 0)
        then = self.grays[first_y : around.bottom + reach, first_x : around.right + reach]
        alike = np.empty(np.subtract(then.shape, now.shape) + 1, np.float32)
        hole = (core.left - left, core.top - top, core.right - left, core.bottom - top)
        kernels.ring.correlations(then, now, hole, alike)
        row, column = divmod(int(alike.argmax()), alike.shape[1])
        if alike[row, column] < ALIKE:
            return None
        x, y = first_x + column - left, first_y + row - top  # how far the scene has moved
        there = place._replace(x=place.x + x * self.pitch, y=place.y + y * self.pitch)
        if iou(there.box, self.target.box) > BESIDE:
            return 0.0
        return correlation(core.of(now, left, top), core.of(self.grays, -x, -y))


class BackdropModel(msgspec.Struct, frozen=True, eq=False, tag="backdrop"):
    """Pictures of the last frames in which the target was seen."""

    snapshots: tuple[Snapshot, ...]
    """The newest last."""
    frames: int = 0
    """Number of frames since the newest one."""


class BackdropSight(NamedTuple):
    """A frame, and what it is compared with."""

    frame: Frame
    model: BackdropModel


class Backdrop(Expert, Config, frozen=True):
    """Whether a place looks as it did before the target came."""

    weight: NonNegative = 16.0
    """Log odds against a place, for each unit of correlation with its backdrop above 0.7 (`ALIKE`).
    With 0 the expert is not asked."""

    def learn(self, frame: Frame, box: Ellipse) -> BackdropModel:
        """Return the model with a picture of the first frame."""
        return BackdropModel((Snapshot.of(frame, box),))

    def look(self, model: BackdropModel, frame: Frame, place: Ellipse) -> BackdropSight:
        """Return the frame with the pictures; each place is compared when it is asked for."""
        return BackdropSight(frame, model)

    def log_odds(self, sight: BackdropSight, place: Ellipse) -> float:
        """Return by how much a place looks as before the target came, by the oldest picture."""
        alike = (snapshot.likeness(sight.frame, place) for snapshot in sight.model.snapshots)
        found = next((each for each in alike if each is not None), 0.0)
        return -self.weight * max(found - ALIKE, 0.0)

    def updated(
        self, model: BackdropModel, frame: Frame, sight: BackdropSight, place: Ellipse, share: float
    ) -> BackdropModel:
        """Return the model with a picture of the frame, if one is due and the target is seen.

        A place that looks as it did before may not be the target's.
        """
        due = model.frames + 1 >= EVERY and share
        if not due or self.log_odds(sight, place) < 0:
            return BackdropModel(model.snapshots, model.frames + 1)
        return BackdropModel((*model.snapshots[1 - MEMORY :], Snapshot.of(frame, place)))

    def placed(self, model: BackdropModel, box: Ellipse) -> BackdropModel:
        """Return a model without pictures: the target was elsewhere in them than was thought."""
        return BackdropModel(())


def gray_points(frame: Frame, points: Points, pitch: float) -> Singles:
    """Return the sums of red, green and blue at points of a frame that are `pitch` apart."""
    left, top, right, bottom = points
    middle = Ellipse((left + right - 1) / 2 * pitch, (top + bottom - 1) / 2 * pitch, 1.0, 1.0)
    out: Singles = cut(frame, middle, (pitch, pitch), (bottom - top, right - left)).sum(axis=0)
    return out
