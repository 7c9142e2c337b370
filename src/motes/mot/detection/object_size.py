"""How large objects are at each place of the picture, learned from patches that moved.

On a ground that is even, the height and the width of an object in the picture are linear functions
of its foot: they grow with the distance from the horizon. So a film teaches them by itself.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from motes.core.geometry import Box, iou
from motes.core.types import Floats
from motes.mot.boxes import as_rows

KEPT = 400
"""Number of latest objects from which sizes are learned: some minutes of a quiet road."""
LEAST = 12
"""Fewer boxes teach nothing."""
PRIOR = 0.3
"""How much sizes spread, as a share, before any is known; it counts as `LEAST` boxes."""
SAME = 0.8
"""A box that overlaps one of the latest by more teaches nothing new, as of a car that stands."""
RECENT = 50
"""Number of these latest boxes."""
ROUNDS = 8
"""Rounds in which the least sum of absolute deviations is approached."""
SPREADS = 2.0
"""An object is larger than usual by this many standard deviations at most, 19 of 20 times."""
ABREAST = 1.6
"""Objects abreast are together at least this many times as wide as one."""
CERTAIN = math.log(ABREAST) / SPREADS
"""Largest standard deviation of a size, in the logarithm: two abreast are surely more than one."""


class ObjectSizes:
    """The sizes of objects by their foot, and `fill`, the share of its box that one usually has.

    They are those of single objects if most patches are single ones.
    """

    def __init__(self) -> None:
        self._boxes, self._fills = np.empty((0, 4)), np.empty(0)
        self._new = 0
        self._lines = np.empty((0, 3))
        self._spreads, self._covariances = np.empty(0), np.empty((0, 3, 3))
        self.fill = 1.0

    @property
    def known(self) -> bool:
        """Whether there were objects enough to learn from."""
        return bool(len(self._lines))

    def learn(self, boxes: Sequence[Box], fills: Sequence[float]) -> None:
        """Learn from the boxes of patches that move, and the shares of these that are theirs."""
        for box, fill in zip(as_rows(boxes), fills, strict=True):
            if len(self._boxes) and (iou(self._boxes[-RECENT:], box) > SAME).any():
                continue
            self._boxes = np.vstack([self._boxes, box])[-KEPT:]
            self._fills = np.append(self._fills, fill)[-KEPT:]
            self._new += 1
        if len(self._boxes) >= LEAST and self._new >= LEAST:
            self._new = 0
            self.fill = float(np.median(self._fills))
            design = _design(_feet(self._boxes))
            fits = [_robust_fit(design, self._boxes[:, 2 + axis]) for axis in range(2)]
            self._lines, self._spreads, self._covariances = map(np.array, zip(*fits, strict=True))

    def at(self, feet: Floats) -> tuple[Floats, Floats]:
        """Return widths and heights (n, 2) at feet, and their spreads, infinite if not known."""
        if not self.known:
            return np.ones((len(feet), 2)), np.full((len(feet), 2), np.inf)
        design = _design(feet)
        sizes = np.maximum(design @ self._lines.T, 1.0)
        off = np.einsum("ij,ajk,ik->ia", design, self._covariances, design)
        spreads = np.sqrt(self._spreads**2 + off / sizes**2)
        sure = (sizes > 1) & (spreads <= CERTAIN)
        return sizes, np.where(sure, spreads, np.inf)

    def largest(self, feet: Floats) -> Floats:
        """Return how wide and high a single object is at most, (n, 2), infinite if not known."""
        sizes, spreads = self.at(feet)
        return sizes * np.exp(SPREADS * spreads)


def _feet(boxes: Floats) -> Floats:
    """Return the middles of the lower edges of boxes (n, 4), (n, 2)."""
    return boxes[:, :2] + boxes[:, 2:] * (0.5, 1.0)


def _design(feet: Floats) -> Floats:
    out = np.ones((len(feet), 3))
    out[:, :2] = feet
    return out


def _robust_fit(design: Floats, sizes: Floats) -> tuple[Floats, float, Floats]:
    """Return a line of least absolute relative deviations, their spread, and its covariance.

    Objects in which two are joined, or that miss a part, are outliers.
    """
    weights = 1 / sizes
    # A picture in which nobody came nearer has no slope: it costs as much as one object does.
    ridge = np.diag([1.0, 1.0, 0.0]) / np.square(np.abs(design).max())
    for _ in range(ROUNDS):
        weighted = design * weights[:, None]
        normal = weighted.T @ weighted + ridge
        line = np.linalg.solve(normal, weighted.T @ (weights * sizes))
        off = np.abs(design @ line - sizes) / sizes
        weights = 1 / sizes / np.sqrt(np.maximum(off, 0.02))
    ratios = np.log(np.maximum(design @ line, 1) / sizes)
    beside = 1.4826 * float(np.median(np.abs(ratios)))
    spread = math.sqrt((LEAST * PRIOR**2 + len(sizes) * beside**2) / (LEAST + len(sizes)))
    relative = design / sizes[:, None]
    return line, spread, spread**2 * np.linalg.inv(relative.T @ relative + ridge)
