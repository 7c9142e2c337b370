"""The ground that two overlapping cameras see: where a point of one picture is in the other.

It is given by a homography, or learned from objects that both cameras saw at the same time.
"""

from __future__ import annotations

from collections import deque

import numpy as np

from motes import Box
from motes.core import Floats
from motes_fleet.cameras.rig_config import Overlap

Point = tuple[float, float]

MEMORY = 500
"""Number of pairs that are kept."""
NEIGHBORS = 12
"""Number of pairs around a point that determine where it is in the other picture."""
NEAR = 2.0
"""The nearest pair lies no farther from a point than this many widths of the object."""
RIDGE = 1.0
"""Variance in square pixels, per pair, that keeps a local map of pairs on one line determined."""
OUTLIER = 3.0
"""A pair counts as wrong if it is this many times farther off than the median pair."""


class CommonGround:
    """Maps points of the ground between the pictures of two cameras, and sizes of objects there.

    Without a homography, a point is mapped by an affine function that fits the nearest pairs of
    feet: least squares, once more without outliers. Pairs determine the sizes in both cases.
    """

    def __init__(self, overlap: Overlap) -> None:
        self.overlap = overlap
        self._pairs: deque[tuple[float, ...]] = deque(maxlen=MEMORY)
        self._homography = None if overlap.homography is None else np.array(overlap.homography)

    def add(self, feet: tuple[Point, Point], first: Box, second: Box) -> None:
        """Learn from the feet and boxes of an object that both cameras see at the same time."""
        sizes = np.log(second[2:]) - np.log(first[2:])
        self._pairs.append((*feet[0], *feet[1], *sizes.tolist()))

    def there(self, point: Point, width: float, start: str) -> Point | None:
        """Return where a point of one camera's picture is in the other's; None if nowhere.

        The camera is named by `start`; an object stands there that is so many pixels wide.
        """
        onward = start == self.overlap.cameras[0]
        if self._homography is not None:
            matrix = self._homography if onward else np.linalg.inv(self._homography)
            x, y, w = (matrix @ (*point, 1.0)).tolist()
            return (x / w, y / w) if w else None
        near = self._near(point, onward)
        here, there = (slice(2), slice(2, 4)) if onward else (slice(2, 4), slice(2))
        if len(near) < NEIGHBORS or np.hypot(*(near[0, here] - point)) > NEAR * width:
            return None
        # Pairs that an error of the pairing has made are far off from what most pairs agree on.
        off = np.hypot(*(near[:, there] - np.median(near[:, there] - near[:, here], axis=0)
                         - near[:, here]).T)  # fmt: skip
        for _ in range(2):
            near = near[off <= OUTLIER * max(float(np.median(off)), 1.0)]
            middle, image = near[:, here].mean(axis=0), near[:, there].mean(axis=0)
            x, y = near[:, here] - middle, near[:, there] - image
            slope = np.linalg.solve(x.T @ x + RIDGE * len(x) * np.eye(2), x.T @ y)
            off = np.hypot(*(y - x @ slope).T)
        found = image + (np.array(point) - middle) @ slope
        return float(found[0]), float(found[1])

    def slope(self, point: Point, width: float, start: str) -> Floats | None:
        """Return the derivative (2, 2) of `there`, by differences of a pixel; None if nowhere."""
        x, y = point
        ends = [
            self.there(each, width, start)
            for each in ((x + 1, y), (x - 1, y), (x, y + 1), (x, y - 1))
        ]
        if any(end is None for end in ends):
            return None
        right, left, down, up = np.array(ends, float)
        return np.stack([right - left, down - up], axis=1) / 2

    def sizes(self, point: Point, slope: Floats, start: str) -> tuple[float, float]:
        """Return how many times wider and higher an object at a point is in the other picture.

        It is the median over the nearest pairs; without any, the scale of the ground.
        """
        onward = start == self.overlap.cameras[0]
        near = self._near(point, onward)
        if not len(near):
            scale = float(np.sqrt(abs(np.linalg.det(slope))))
            return scale, scale
        wider, higher = np.exp(np.median(near[:, 4:], axis=0) * (1 if onward else -1)).tolist()
        return wider, higher

    def _near(self, point: Point, onward: bool) -> Floats:
        """Return the nearest pairs (k, 6), the nearest first."""
        pairs = np.array(self._pairs, float).reshape(-1, 6)
        here = pairs[:, :2] if onward else pairs[:, 2:4]
        order = np.argsort(np.hypot(*(here - point).T), kind="stable")
        near: Floats = pairs[order[:NEIGHBORS]]
        return near
