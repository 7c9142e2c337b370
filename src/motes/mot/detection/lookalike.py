"""Find all objects that look like one, as the players of a team: Zhao and Pei, section 3.

What moves before the background, also before that of a camera that pans, or what another detector
finds, is compared with the given object by its colors and its oriented gradients. Only those colors
count that the object has more of than its surroundings: the box of a player on a lawn is mostly
lawn. A patch of several objects is divided where it looks like the given one.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Mapping, Sequence

import numpy as np

from motes.core.config import Config, Share
from motes.core.detection import Detection, Detector, DetectorConfig, check_callable
from motes.core.frame import Frame
from motes.core.geometry import Box, Ellipse, as_region, region_within
from motes.core.types import Flags, Floats
from motes.cues.color import Color, ColorModel
from motes.cues.gradients import Hog
from motes.cues.sampling import Lattice
from motes.mot.detection.panned_background import KNOWN, PannedBackground
from motes.sot.filtering.appearance_rule import AppearanceRule

STEPS = 4
"""Steps of the grid of places in a target's width and height."""
SIZES = (0.8, 1.0, 1.25)
"""Sizes that are tried, as multiples of the target's."""
SHIFTS = 5
"""Mean-shift iterations from the best place on the grid."""
SURROUNDINGS = 3.0
"""Width and height of the surroundings, as multiples of the target's."""
ALIKE = 0.1
"""A size is about as similar as the best one if its rho is less by this share at most."""
LIMIT = 100
"""Largest number of places that are looked at closely in a frame, and so of detections.

A team needs some 25. Where everything has the target's colors, as in a frame without any structure,
there would be a place for every step of the grid.
"""
SEVERAL = 1.4
"""A detection that is larger than the target by this factor may hold several objects."""
MOVING = 0.2
"""Least share of a region that is foreground."""


class LookalikeConfig(DetectorConfig, Config, frozen=True, tag="like"):
    """Settings of the detector of regions similar to one region of the first frame."""

    box: tuple[float, float, float, float]
    """The box of the object in the first frame: x, y, width, height."""
    color: Color = Color(space="hsv+v", bins=(8, 8, 8), sampling=Lattice(points=128))
    """The histogram of colors that is compared; by default that of Zhao and Pei."""
    rule: AppearanceRule = AppearanceRule(margin=0.5)
    """The appearance rule: how similar the colors of a region must be."""
    hog: Hog = Hog()
    """The oriented gradients that are compared."""
    distance: Share = 0.4
    """Largest mean of the distances of colors and gradients, T in the paper. With a larger value
    more regions are similar."""

    def detector(self) -> LookalikeDetector:
        """Return the detector."""
        return LookalikeDetector(self)


class LookalikeDetector:
    """Finds all moving regions that are similar to one region of the first frame.

    A region's rho must fulfill the appearance rule of Nummiaro et al., with the other places of the
    first frame as background; and the mean of its distances in color and in gradients must be below
    `distance`. In the first frame, regions that stand still are found too, and then again. All
    detections have the score 1.

    Parameters
    ----------
    like
        The box in the first frame, x, y, width, height; or a configuration.
    candidates
        The detector whose detections are compared; by default, what moves before the background.

    Raises
    ------
    ConfigError
        If `like` is no box, or `candidates` no detector; on the first frame, if the box does not
        fit it.
    """

    def __init__(
        self, like: Sequence[float] | LookalikeConfig, candidates: Detector | None = None
    ) -> None:
        if not isinstance(like, LookalikeConfig):
            like = LookalikeConfig(as_region(like))  # type: ignore[arg-type]
        if candidates is not None:
            check_callable(candidates)
        self._box, self._color, self._rule = Box(*like.box), like.color, like.rule
        self._hog, self._distance = like.hog, like.distance
        self._finder = candidates
        self._background = PannedBackground() if candidates is None else None
        self._begun = False
        self._least = 0.0
        self._last: list[Box] = []
        self._past: deque[tuple[Frame, Floats]] = deque(maxlen=KNOWN)

    @property
    def own_background(self) -> bool:
        """Whether it compares what moves before a background that moves along with the camera."""
        return self._background is not None

    @property
    def warnings(self) -> Mapping[str, str]:
        """The warnings of the detector whose detections are compared."""
        return dict(getattr(self._finder, "warnings", {}))

    @property
    def motion(self) -> Floats | None:
        """The homography of the camera's motion to the latest frame, if it is known."""
        return None if self._background is None else self._background.motion

    def __call__(self, frame: Frame) -> list[Detection]:
        """Return the similar regions in a frame, the most similar colors first."""
        if not self._begun:
            region = region_within(self._box, frame.width, frame.height)
            self._model = self._distinctive(frame, region)
            self._edges = self._hog.learn(frame, region)
            background = self._rule.background(
                self._color, self._model, frame, region, target_in_frame=True
            )
            self._least = self._rule.threshold(background)
            self._begun = True
        places = self._candidates(frame)  # as many as the box's size allows, which was checked
        motion = self.motion
        if motion is None:
            self._past.clear()
        else:
            self._past.extend([(past, motion @ moved) for past, moved in self._past])
        rho = 1 - self._color.distances(self._model, frame, places) ** 2
        order = np.argsort(-rho)
        found: list[Detection] = []
        looks = 0
        for i in order[rho[order] > self._least].tolist():
            if looks == LIMIT:
                break
            place = Ellipse(*places[i].tolist())
            if any(_meet(places[i], each.box) for each in found) or self._stays(place):
                continue
            looks += 1
            place = self._sized(frame, self._shifted(frame, place))
            distance = self._apart(frame, place)
            if distance >= self._distance or self._stays(place) or self._stood(place):
                continue
            if not any(_meet(np.array(place), each.box) for each in found):
                found.append(Detection(place.box))
        self._last = [each.box for each in found]
        self._past.append((frame, np.eye(3)))
        return found

    def _stays(self, place: Ellipse) -> bool:
        """Return whether a place is writing, which stays in the picture while the camera moves."""
        return self._background is not None and self._background.stays(place.box)

    def _stood(self, place: Ellipse) -> bool:
        """Return whether the ground at a place where nobody was known looked alike before.

        Then it is a part of the background that was moved along badly, as stands behind a pitch.
        """
        if len(self._past) < KNOWN or self._known(np.array([place]))[0]:
            return False
        before, moved = self._past[0]
        x, y, w = np.linalg.solve(moved, (place.x, place.y, 1))
        there = np.array([place._replace(x=x / w, y=y / w)])
        rho = 1 - self._color.distances(self._model, before, there)[0] ** 2
        return bool(rho > self._least)

    def _apart(self, frame: Frame, place: Ellipse) -> float:
        """Return the mean of the distances in color and in gradients of a place from the target."""
        region = np.array([place])
        color = self._color.distances(self._model, frame, region)[0]
        return float(color + self._hog.distances(self._edges, frame, region)[0]) / 2

    def _sized(self, frame: Frame, place: Ellipse) -> Ellipse:
        """Return a place with the largest of the sizes that are about as similar as the best one.

        A part of the target is as similar as the whole, or more.
        """
        sides = [(size * self._box.width / 2, size * self._box.height / 2) for size in SIZES]
        regions = np.array([place._replace(a=a, b=b) for a, b in sides])
        rho = 1 - self._color.distances(self._model, frame, regions) ** 2
        best = np.flatnonzero(rho >= (1 - ALIKE) * rho.max())[-1]
        return Ellipse(*regions[best].tolist())

    def _candidates(self, frame: Frame) -> Floats:
        """Return the ellipses (N, 5) that are compared with the target."""
        grid = self._grid(frame)
        if self._background is not None:
            moving = self._background.foreground(np.ascontiguousarray(frame.pixels))
            apart = _shares(moving, grid, frame) >= MOVING
            return grid[apart | self._known(grid)]
        assert self._finder is not None
        boxes = [each.box for each in self._finder(frame)]
        own = np.array([Ellipse.from_box(box) for box in boxes]).reshape(-1, 5)
        large = [box for box in boxes if box.width * box.height > SEVERAL * np.prod(self._box[2:])]
        inside = [any(_meet(each, box) for box in large) for each in grid]
        return np.concatenate([own, grid[np.array(inside, bool)]])

    def _known(self, grid: Floats) -> Flags:
        """Return which ellipses (N, 5) lie where an object of the frame before would be at rest.

        So an object that stands still is found again.
        """
        out, motion = np.zeros(len(grid), np.bool_), self.motion
        if motion is None:
            return out
        for x, y, width, height in self._last:
            moved = motion @ (x + width / 2, y + height / 2, 1)
            away = np.abs(grid[:, :2] - moved[:2] / moved[2])
            out |= (away < (width / 2, height / 2)).all(axis=1)
        return out

    def _distinctive(self, frame: Frame, region: Ellipse) -> ColorModel:
        """Return a region's histogram over the colors that it has more of than its surroundings.

        The weight of a bin is the posterior of the region against its surroundings, or 0 if that
        is not above one half. If it never is, the whole histogram is used.
        """
        own = self._color.learn(frame, region).histogram
        wide = region._replace(a=SURROUNDINGS * region.a, b=SURROUNDINGS * region.b)
        both = self._color.learn(frame, wide).histogram
        around = np.maximum(both - own / SURROUNDINGS**2, 0) / (1 - SURROUNDINGS**-2)
        sums = own + around
        posterior = np.divide(own, sums, out=np.zeros_like(own), where=sums > 0)
        histogram = own * posterior * (posterior > 0.5)
        if histogram.any():
            own = histogram / histogram.sum()
        return ColorModel(own, own)

    def _grid(self, frame: Frame) -> Floats:
        """Return the ellipses (N, 5) that are compared with the model."""
        grids = [np.empty((0, 5))]
        for size in SIZES:
            a, b = size * self._box.width / 2, size * self._box.height / 2
            if 2 * a > frame.width or 2 * b > frame.height:
                continue
            y, x = np.mgrid[
                b : frame.height - b : 2 * b / STEPS, a : frame.width - a : 2 * a / STEPS
            ]
            grid = np.zeros((x.size, 5))
            grid[:, 0], grid[:, 1], grid[:, 2], grid[:, 3] = x.ravel(), y.ravel(), a, b
            grids.append(grid)
        return np.concatenate(grids)

    def _shifted(self, frame: Frame, place: Ellipse) -> Ellipse:
        """Return a place after some iterations of mean shift."""
        for _ in range(SHIFTS):
            x, y = self._color.shift(self._model, frame, place)
            place = place._replace(x=x, y=y)
        return place


def _shares(mask: Flags, ellipses: Floats, frame: Frame) -> Floats:
    """Return the share of a reduced mask in the box of each ellipse (N, 5): (N,)."""
    sums = np.zeros((mask.shape[0] + 1, mask.shape[1] + 1))
    sums[1:, 1:] = mask.cumsum(axis=0).cumsum(axis=1)
    scale = np.array([mask.shape[1] / frame.width, mask.shape[0] / frame.height])
    limits = np.array(mask.shape[::-1])
    low = np.rint((ellipses[:, :2] - ellipses[:, 2:4]) * scale).clip(0, limits).astype(int)
    high = np.rint((ellipses[:, :2] + ellipses[:, 2:4]) * scale).clip(0, limits).astype(int)
    inside = sums[high[:, 1], high[:, 0]] - sums[low[:, 1], high[:, 0]]
    inside += sums[low[:, 1], low[:, 0]] - sums[high[:, 1], low[:, 0]]
    out: Floats = inside / np.maximum((high - low).prod(axis=1), 1)
    return out


def _meet(ellipse: Floats, box: Box) -> bool:
    """Return whether an ellipse's center lies in a box."""
    x, y = box.x + box.width / 2, box.y + box.height / 2
    return bool(abs(ellipse[0] - x) < box.width / 2 and abs(ellipse[1] - y) < box.height / 2)
