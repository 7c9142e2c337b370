"""The square of a frame that a network sees, and its pixels as the network's input."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from motes import kernels
from motes.core.errors import ConfigError
from motes.core.frame import Frame
from motes.core.types import Floats, Singles

LARGEST_SIDE = 2**20
"""Pixels of the side of the largest region."""
BLACK = np.zeros(3)


class Region(NamedTuple):
    """A square of whole pixels in a frame, which may reach outside."""

    left: int
    top: int
    """Its first column and row of pixels."""
    side: int
    """Its numbers of columns and of rows."""

    @classmethod
    def around(cls, x: float, y: float, side: float) -> Region:
        """Return the region of about this side whose center is nearest to x, y.

        Raises a ConfigError if no frame has a place so large or so far.
        """
        if not max(abs(x), abs(y), side) <= LARGEST_SIDE:
            raise ConfigError(
                f"A network cannot look at a region of {side:.0f} pixels around {x:.0f}, {y:.0f}; "
                f"give a place in the frame."
            )
        whole = max(round(side), 1)
        return cls(round(x - (whole - 1) / 2), round(y - (whole - 1) / 2), whole)


def read(frame: Frame, region: Region, size: int, fill: Floats) -> Singles:
    """Return a region of a frame in `size` rows and columns (1, 3, size, size): RGB, 0 to 255.

    Pixels are mixed bilinearly, not averaged, and rounded as by OpenCV's `resize`: networks have
    learned from such pictures, and choose other boxes where pixels differ by one. Outside the frame
    is the color `fill` (3,).
    """
    out = np.empty((1, 3, size, size), np.float32)
    left, top, side = region
    kernels.network_input.read_square(frame.pixels, left, top, side, fill, out[0])
    return out


def mean_color(frame: Frame) -> Floats:
    """Return the mean of a frame's red, green and blue (3,)."""
    mean: Floats | None = frame.cache.get(mean_color)
    if mean is None:
        mean = frame.cache[mean_color] = np.empty(3)
        kernels.network_input.mean_color(frame.pixels, mean)
    return mean


def reaches_outside(frame: Frame, region: Region) -> bool:
    """Return whether a part of a region lies outside its frame."""
    left, top, side = region
    return min(left, top) < 0 or left + side > frame.width or top + side > frame.height
