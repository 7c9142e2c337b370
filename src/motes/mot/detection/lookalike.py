"""Find all objects that look like one, as the players of a team: Zhao and Pei, section 4.

Only colors are compared. So camera and objects may move or stand still. Only those colors count
that the object has more of than its surroundings: the box of a player on a lawn is mostly lawn.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from motes.core.config import Config
from motes.core.detection import Detection, DetectorConfig
from motes.core.frame import Frame
from motes.core.geometry import Box, Ellipse, region_within
from motes.core.types import Floats
from motes.cues.color import Color, ColorModel
from motes.cues.sampling import Lattice
from motes.sot.filtering.appearance_rule import AppearanceRule

STEPS = 4
"""Steps of the grid of places in a target's width and height."""
SIZES = (0.8, 1.0, 1.25)
"""Sizes that are tried, as multiples of the target's."""
SHIFTS = 5
"""Mean-shift iterations from the best place on the grid."""
SURROUNDINGS = 3.0
"""Width and height of the surroundings, as multiples of the target's."""
LIMIT = 100
"""Largest number of detections in a frame."""


class LookalikeConfig(DetectorConfig, Config, frozen=True, tag="like"):
    """Settings of the detector of regions similar to one region of the first frame.

    Attributes
    ----------
    box
        The box of the object in the first frame: x, y, width, height.
    color
        The histogram of colors that is compared; by default that of Zhao and Pei.
    rule
        The appearance rule: how similar the colors of a region must be.
    """

    box: tuple[float, float, float, float]
    color: Color = Color(space="hsv+v", bins=(8, 8, 8), sampling=Lattice(points=128))
    rule: AppearanceRule = AppearanceRule(margin=0.7)

    def detector(self) -> LookalikeDetector:
        """Return the detector."""
        return LookalikeDetector(self)


class LookalikeDetector:
    """Finds all regions whose colors are similar to those of one region in the first frame.

    Their rho must fulfill the appearance rule of Nummiaro et al., with the other places of the
    first frame as background. All detections have the score 1.

    Parameters
    ----------
    like
        The box in the first frame, x, y, width, height; or a configuration.

    Raises
    ------
    ConfigError
        On the first frame, if the box does not fit it.
    """

    def __init__(self, like: Sequence[float] | LookalikeConfig) -> None:
        if not isinstance(like, LookalikeConfig):
            like = LookalikeConfig(tuple(like))  # type: ignore[arg-type]
        self._box, self._color, self._rule = Box(*like.box), like.color, like.rule
        self._model: ColorModel | None = None
        self._least = 0.0

    def __call__(self, frame: Frame) -> list[Detection]:
        """Return the similar regions in a frame, the most similar first."""
        if self._model is None:
            region = region_within(self._box, frame.width, frame.height)
            self._model = self._distinctive(frame, region)
            background = self._rule.background(
                self._color, self._model, frame, region, target_in_frame=True
            )
            self._least = self._rule.threshold(background)
        places = self._grid(frame)
        rho = 1 - self._color.distances(self._model, frame, places) ** 2
        order = np.argsort(-rho)
        found: list[Detection] = []
        for i in order[rho[order] > self._least].tolist():
            if len(found) == LIMIT:
                break
            if not any(_meet(places[i], each.box) for each in found):
                place = self._shifted(frame, Ellipse(*places[i].tolist()))
                if not any(_meet(np.array(place), each.box) for each in found):
                    found.append(Detection(place.box))
        return found

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
        assert self._model is not None
        for _ in range(SHIFTS):
            x, y = self._color.shift(self._model, frame, place)
            place = place._replace(x=x, y=y)
        return place


def _meet(ellipse: Floats, box: Box) -> bool:
    """Return whether an ellipse's center lies in a box."""
    x, y = box.x + box.width / 2, box.y + box.height / 2
    return bool(abs(ellipse[0] - x) < box.width / 2 and abs(ellipse[1] - y) < box.height / 2)
