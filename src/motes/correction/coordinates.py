"""The coordinates in which regions are smoothed: places in sides, logarithms of sizes, angles."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from motes.core.geometry import Ellipse
from motes.core.types import Floats

LEAST_CONFIDENCE, LARGEST_CONFIDENCE = 0.01, 0.99999
"""Confidences outside of these do not tell how far off a box is."""


class Coordinates(NamedTuple):
    """Coordinates of the regions in some frames.

    Where all keyframes are boxes, regions are boxes too, (x, y, log a, log b), and their ellipses
    are upright. Otherwise they are ellipses, with the angle as a fifth coordinate.
    """

    side: float
    """The unit of x and y in pixels: the mean side of the keyframes."""
    angles: Floats | None
    """(n,), an angle near that of the region in each frame; None for boxes."""

    @classmethod
    def of(
        cls, keys: Sequence[Ellipse], ellipses: Floats, boxes: bool | None = None
    ) -> Coordinates:
        """Return the coordinates for keyframes, and for regions (n, 5) in their order.

        `boxes` is whether all keyframes are boxes; if it is not known, those without angles are.
        """
        side = math.exp(float(np.mean([math.log(key.side) for key in keys])))
        if boxes is None:
            boxes = all(key.theta == 0 for key in keys)
        return cls(
            side, None if boxes else np.unwrap(np.nan_to_num(ellipses[:, 4]), period=math.pi)
        )

    @property
    def dimensions(self) -> int:
        """The number of coordinates."""
        return 4 if self.angles is None else 5

    def values(self, ellipses: Floats, frame: int | slice = slice(None)) -> Floats:
        """Return the coordinates (n, k) of ellipses (n, 5) in all frames, or in one frame."""
        x, y, a, b, theta = ellipses.T
        if self.angles is None:
            cos, sin = np.cos(theta), np.sin(theta)
            a, b = np.hypot(a * cos, b * sin), np.hypot(a * sin, b * cos)
        a, b = np.maximum(a, 0.5), np.maximum(b, 0.5)
        columns = [x / self.side, y / self.side, np.log(a), np.log(b)]
        if self.angles is not None:
            near = self.angles[frame]
            columns.append(near + np.mod(theta - near + math.pi / 2, math.pi) - math.pi / 2)
        return np.stack(columns, axis=1)

    def relative(self, ellipses: Floats, variances: Floats) -> Floats:
        """Return variances (n, 5) of ellipses in these coordinates, relative to their medians."""
        units = np.stack(
            [np.full(len(ellipses), self.side)] * 2 + [ellipses[:, 2], ellipses[:, 3]], axis=1
        )
        scaled = np.concatenate([variances[:, :4] / units**2, variances[:, 4:]], axis=1)
        middle = np.median(scaled, axis=0)
        shares = np.divide(scaled, middle, out=np.ones_like(scaled), where=middle > 0)
        out: Floats = np.clip(shares[:, : self.dimensions], 0.1, 10.0)
        return out

    def ellipses(self, mean: Floats, variance: Floats) -> tuple[Floats, Floats]:
        """Return the ellipses (n, 5) of coordinates, and the variances (n, 5) of theirs."""
        a, b = np.exp(mean[:, 2:4].T)
        x, y = mean[:, :2].T * self.side
        turned = self.angles is not None
        theta = mean[:, 4] if turned else np.zeros(len(mean))
        out = np.zeros((len(mean), 5))
        out[:, :2] = variance[:, :2] * self.side**2
        out[:, 2:4] = variance[:, 2:4] * np.stack([a, b], axis=1) ** 2
        if turned:
            out[:, 4] = variance[:, 4]
        return np.stack([x, y, a, b, theta], axis=1), out


def overlap_probability(ellipses: Floats, variances: Floats, overlap: float) -> Floats:
    """Return the probability (n,) that each region overlaps its target by more than `overlap`.

    A box that is off by the shares u and v of its sides, and too large by factors of e^s and e^t,
    overlaps by about exp(-2 |u| - 2 |v| - |s| - |t|). The errors are normal; the sum of their
    magnitudes is taken as Rayleigh's distance of the same mean square.
    """
    a, b = ellipses[:, 2], ellipses[:, 3]
    place = variances[:, 0] / a**2 + variances[:, 1] / b**2  # 2 u is the error over the half-axis
    size = variances[:, 2] / a**2 + variances[:, 3] / b**2
    square = np.maximum(place + size, 1e-12)
    return 1 - np.exp(-(math.log(overlap) ** 2) / square)


def variances_told(ellipses: Floats, confidence: Floats, overlap: float) -> Floats:
    """Return variances (n, 5) for which `overlap_probability` is the confidence (n,).

    All four sides of a box are as much off, in shares of themselves; the angle is as it is.
    """
    sure = np.clip(confidence, LEAST_CONFIDENCE, LARGEST_CONFIDENCE)
    square = -(math.log(overlap) ** 2) / np.log1p(-sure)
    out = np.zeros((len(ellipses), 5))
    out[:, :4] = square[:, None] / 4 * ellipses[:, [2, 3, 2, 3]] ** 2
    return out
