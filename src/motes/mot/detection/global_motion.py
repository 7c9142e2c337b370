"""The motion of a camera from one picture to the next, from corners that are followed.

Corners are followed by the pyramid of Lucas and Kanade, and RANSAC finds the motion that most of
them share: they lie on the background. They are spread over the picture, so that the background
has most of them also where a broadcaster's logo has the strongest ones.
"""

from __future__ import annotations

from typing import Literal, TypeAlias

import numpy as np

from motes.core.callables import optional
from motes.core.types import Bytes, Flags, Floats, Singles
from motes.mot.detection.morphology import opencv

Model: TypeAlias = Literal["homography", "similarity"]

WIDTH = 320
"""Pictures are reduced to this width at most. With 640 the motion is no more exact."""
WINDOW = 11, 11
"""Pixels around a corner that are followed. 21 x 21 hold more of what moves otherwise, and take
twice the time."""
CELLS = 16
"""Cells of corners in a picture's longer side ("bucketing"; Kitt et al., 2010)."""
CORNERS = 3
"""Largest number of corners of a cell, so some 400 in all."""
APART = 4
"""Pixels to the next corner that is stronger, at least."""
WEAKEST = 5e-4
"""Least strength of a corner: of those that noise of 4 gray values makes, 97 of 100 are weaker."""
FEWEST = 12
"""Least number of corners that agree; a homography has 8 unknowns, so 4 corners always do."""
OFF: dict[Model, float] = {"homography": 1.0, "similarity": 0.5}
"""Largest distance of a corner that agrees, in pixels.

Of a flat ground half of it would be more exact; where there is depth, one leaves less misfit.
"""
NO_BOXES: Floats = np.empty((0, 4))


def _motion(before: Bytes, after: Bytes, model: Model, objects: Floats) -> Floats | None:
    """Return the motion (3, 3) from a gray picture to the next; None if it is not clear."""
    cv2 = opencv()
    corners = _corners(before)
    corners = corners[~_inside(corners, objects)]
    if len(corners) < FEWEST:
        return None
    moved, found, _ = cv2.calcOpticalFlowPyrLK(before, after, corners, None, winSize=WINDOW)
    seen = found.ravel() == 1
    if seen.sum() < FEWEST:
        return None
    if model == "homography":
        matrix, agrees = cv2.findHomography(corners[seen], moved[seen], cv2.RANSAC, OFF[model])
    else:
        matrix, agrees = cv2.estimateAffinePartial2D(
            corners[seen], moved[seen], method=cv2.RANSAC, ransacReprojThreshold=OFF[model]
        )
    if matrix is None or agrees.sum() < FEWEST:
        return None
    return matrix if model == "homography" else np.vstack([matrix, (0, 0, 1)])


def _corners(gray: Bytes) -> Singles:
    """Return the strongest corners (N, 2) of each cell of a gray picture (H, W)."""
    cv2 = opencv()
    strength = cv2.cornerMinEigenVal(gray, 3)
    around = cv2.dilate(strength, np.ones((2 * APART + 1, 2 * APART + 1), np.uint8))
    y, x = np.nonzero((strength == around) & (strength > WEAKEST))
    side = max(gray.shape) / CELLS
    cell = (y // side) * CELLS + x // side
    order = np.lexsort((-strength[y, x], cell))
    rank = np.arange(len(order)) - np.searchsorted(cell[order], cell[order])
    best = order[rank < CORNERS]
    return np.stack([x[best], y[best]], axis=1).astype(np.float32)


def _inside(points: Singles, boxes: Floats) -> Flags:
    """Return which points (N, 2) lie in one of the boxes (M, 4): (N,)."""
    away = points[:, None] - boxes[:, :2]
    inside = ((away >= 0) & (away < boxes[:, 2:])).all(axis=2)
    out: Flags = np.logical_or.reduce(inside, axis=1)
    return out


def reduced(pixels: Bytes, width: int) -> tuple[Bytes, float]:
    """Return a picture (H, W, ...) that is no wider than `width`, and its scale."""
    scale = min(width / pixels.shape[1], 1.0)
    size = round(scale * pixels.shape[1]), max(1, round(scale * pixels.shape[0]))
    small: Bytes = opencv().resize(pixels, size, interpolation=opencv().INTER_AREA)
    return small, scale


def scaled(motion: Floats, scale: float) -> Floats:
    """Return a motion (3, 3) of pictures as that of the same pictures scaled."""
    matrix = np.diag([scale, scale, 1.0])
    return matrix @ motion @ np.linalg.inv(matrix)


class GlobalMotion:
    """The motion of a camera, picture by picture.

    A motion is a similarity, of a camera that pans, turns about its axis and zooms; or a
    homography, with twice as many unknowns. Raises a MissingDependencyError if OpenCV is not
    installed.
    """

    def __init__(self, model: Model = "similarity") -> None:
        optional("cv2", "The motion of a camera needs OpenCV", "motes[opencv]")
        self._model = model
        self._gray: Bytes | None = None

    def forget(self) -> None:
        """Take the next picture as the first one."""
        self._gray = None

    def update(self, pixels: Bytes, objects: Floats = NO_BOXES) -> Floats | None:
        """Return the motion (3, 3) of the background from the last picture (H, W, 3) to this one.

        It is None in the first picture, and where it is not clear. `objects` are boxes (M, 4) of
        the last picture: what they hold is not the background.
        """
        cv2 = opencv()
        whole: Bytes = cv2.cvtColor(np.ascontiguousarray(pixels), cv2.COLOR_RGB2GRAY)
        gray, scale = reduced(whole, WIDTH)
        before, self._gray = self._gray, gray
        if before is None or before.shape != gray.shape:
            return None
        motion = _motion(before, gray, self._model, scale * objects)
        return None if motion is None else scaled(motion, 1 / scale)
