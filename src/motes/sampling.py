"""Which pixels of an ellipse are read."""

from __future__ import annotations

from functools import cache
from typing import Annotated

import numpy as np
from msgspec import Meta
from numpy.typing import NDArray

from motes.config import Config


class EveryPixel(Config, frozen=True, tag="every_pixel"):
    """Every pixel whose center lies inside the ellipse: the reference; cost grows with area."""

    @property
    def lattice(self) -> NDArray[np.float64]:
        """No lattice: (0, 2)."""
        return np.empty((0, 2))


class Lattice(Config, frozen=True, tag="lattice"):
    """A fixed set of points spread evenly over the unit disk, mapped by each ellipse.

    A candidate costs the same whatever its size, and its region's histogram is an unbiased
    estimate of the one over every pixel.

    Attributes
    ----------
    points
        How many pixels of an ellipse are read.
    """

    points: Annotated[int, Meta(ge=8, le=65536)] = 256

    @property
    def lattice(self) -> NDArray[np.float64]:
        """The points (u, v) in the unit disk, shape (points, 2)."""
        return sunflower(self.points)


Sampling = EveryPixel | Lattice


@cache
def sunflower(points: int) -> NDArray[np.float64]:
    """Return `points` points (u, v) that cover the unit disk with equal area for each.

    Vogel's spiral: radius sqrt((i + 1/2) / n), angle i times the golden angle. The points are
    ordered by angular sector so that consecutive reads are near each other in memory.
    """
    i = np.arange(points)
    radius = np.sqrt((i + 0.5) / points)
    angle = i * np.pi * (3 - np.sqrt(5))
    disk = np.stack([radius * np.cos(angle), radius * np.sin(angle)], axis=1)
    rows = np.floor((disk[:, 1] + 1) * np.sqrt(points) / 2)
    ordered = np.ascontiguousarray(disk[np.lexsort((disk[:, 0], rows))])
    ordered.flags.writeable = True
    return ordered
