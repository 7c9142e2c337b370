"""Objects cut out of a picture, and how they are drawn into another one."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np
from PIL import Image

from motes.core.geometry import Box
from motes.core.types import Bytes, Floats, Singles

SUPERSAMPLING = 2
"""An object is drawn this many times finer, and averaged: its edge is then as soft as a lens's."""


class Pose(NamedTuple):
    """Where and how a cutout is drawn.

    Attributes
    ----------
    x, y
        Center in the picture.
    width, height
        Factors of the cutout's own width and height.
    theta
        Angle by which it is turned, in radians.
    """

    x: float
    y: float
    width: float
    height: float
    theta: float = 0.0

    @property
    def matrix(self) -> Floats:
        """The matrix (2, 2) from the cutout to the picture, both relative to the center."""
        cos, sin = math.cos(self.theta), math.sin(self.theta)
        return np.array([[cos, -sin], [sin, cos]]) * (self.width, self.height)


@dataclass(frozen=True, eq=False)
class Cutout:
    """An object with a soft matte.

    Attributes
    ----------
    pixels
        (H, W, 3), RGB; also where the matte is 0, the colors continue those of the object.
    matte
        (H, W), from 0 to 1, how much of a pixel is the object's.
    """

    pixels: Bytes
    matte: Singles

    @cached_property
    def outline(self) -> Floats:
        """The corners (n, 2) of the pixels at its border, relative to the picture's center."""
        inside = self.matte >= 0.5
        rows, columns = np.arange(len(inside)), np.arange(inside.shape[1])
        edges = []
        for y in rows[inside.any(axis=1)].tolist():
            x = columns[inside[y]]
            edges += [(x[0], y), (x[0], y + 1), (x[-1] + 1, y), (x[-1] + 1, y + 1)]
        outline: Floats = np.array(edges, np.float64) - np.array(inside.shape[::-1]) / 2
        return outline

    @cached_property
    def side(self) -> float:
        """The square root of the area of its box, in pixels."""
        return float(np.sqrt(np.prod(np.ptp(self.outline, axis=0))))

    @property
    def inside(self) -> Bytes:
        """The colors (n, 3) of the object's own pixels."""
        return self.pixels[self.matte >= 0.5]

    def box(self, pose: Pose) -> Box:
        """Return the smallest box around the drawn object."""
        corners = self.outline @ pose.matrix.T
        (left, top), (width, height) = corners.min(axis=0), np.ptp(corners, axis=0)
        return Box(*map(float, (pose.x + left + 0.5, pose.y + top + 0.5, width, height)))

    @cached_property
    def _rgba(self) -> Image.Image:
        alpha = np.rint(255 * self.matte).astype(np.uint8)
        return Image.fromarray(np.dstack([self.pixels, alpha]))

    @cached_property
    def _reduced(self) -> dict[tuple[int, int], Image.Image]:
        return {}

    def _at_most(self, wide: int, high: int) -> Image.Image:
        """Return the picture averaged over blocks of pixels."""
        key = (wide, high)
        if key not in self._reduced:
            self._reduced[key] = self._rgba.reduce(key)
        return self._reduced[key]

    def draw(self, picture: Singles, pose: Pose) -> tuple[tuple[slice, slice], Singles]:
        """Draw the object into a picture (H, W, 3), which is changed.

        Returns
        -------
        part, matte
            The part of the picture that may be changed, and the object's matte in it.
        """
        size = np.array(self.matte.shape[::-1], np.float64)
        matrix = pose.matrix
        reach = np.abs(matrix) @ size / 2 + 1
        center = np.array([pose.x, pose.y]) + 0.5  # from the corner of the first pixel
        low = np.maximum(np.floor(center - reach), 0).astype(int)
        high = np.minimum(np.ceil(center + reach), picture.shape[1::-1]).astype(int)
        part = slice(low[1], max(high[1], low[1])), slice(low[0], max(high[0], low[0]))
        if not picture[part].size:
            return part, np.zeros(picture[part].shape[:2], np.float32)
        steps = 1 / (SUPERSAMPLING * np.array([pose.width, pose.height]))
        wide, tall = np.maximum(np.floor(steps), 1).astype(int).tolist()
        inverse = np.linalg.inv(matrix)
        shift = inverse @ (low - center) + size / 2
        coefficients = np.column_stack([inverse / SUPERSAMPLING, shift]) / [[wide], [tall]]
        fine = self._at_most(wide, tall).transform(
            tuple((SUPERSAMPLING * (high - low)).tolist()),
            Image.Transform.AFFINE,
            coefficients.ravel().tolist(),
            Image.Resampling.BICUBIC,
        )
        drawn = np.asarray(fine.reduce(SUPERSAMPLING), np.float32)
        matte: Singles = drawn[:, :, 3] / np.float32(255)
        picture[part] += (drawn[:, :, :3] - picture[part]) * matte[:, :, None]
        return part, matte
