"""Which pixels of an ellipse are read."""

from __future__ import annotations

from functools import cache, cached_property
from typing import Annotated, Literal, Self

import numpy as np
from msgspec import Meta
from msgspec.structs import replace

from motes import kernels
from motes.core.config import Config
from motes.core.types import Singles
from motes.kernels.structures import PixelGrid, Reading

Profile = Literal["epanechnikov", "radial", "uniform", "gaussian"]
"""How a pixel's weight falls with its distance from the center.

`radial`: Nummiaro et al., equation 2, 1 - r² with r the distance over sqrt(a² + b²); only pixels
inside the ellipse count. `epanechnikov`: 1 - r² with r measured in the ellipse's own half-axes, so
that weights fall to zero at its border. `uniform`: equal weights. `gaussian`: Zhao and
Pei, equation 1, exp(-r² / (2 delta²)) with r in half-axes too and delta = 1 (section 4). A delta of
1 pixel would give the center all the weight.
"""

PROFILES: dict[str, int] = {
    "epanechnikov": kernels.sampling.EPANECHNIKOV,
    "radial": kernels.sampling.RADIAL,
    "uniform": kernels.sampling.UNIFORM,
    "gaussian": kernels.sampling.GAUSSIAN,
}


DENSE = 4096
"""Number of points of the lattice that reads a target model."""


class _Grid(Config, frozen=True):
    """What samplings are where they say nothing else: every pixel of the image's own grid."""

    @property
    def dense(self) -> Self:
        """The sampling that reads a target model: the same, so that both are comparable."""
        return self

    @property
    def lattice(self) -> Singles:
        """No lattice: (2, 0)."""
        return np.empty((2, 0), np.float32)

    @property
    def grid(self) -> PixelGrid:
        """Steps of rows and columns of the pixels that are read: every one."""
        return PixelGrid(1, 1)


class EveryPixel(_Grid, frozen=True, tag="every_pixel"):
    """Every pixel whose center lies inside the ellipse; the cost grows with the ellipse's area."""


class Checkerboard(_Grid, frozen=True, tag="checkerboard"):
    """Half or a quarter of the pixels inside the ellipse: Ng and Delp, section 3.5 and figure 2.

    They are fixed in the image, not in the ellipse: where two ellipses overlap, they read the same
    pixels.
    """

    share: Literal["half", "quarter"] = "half"
    """`half` reads the pixels whose row and column have an even sum; `quarter` reads those whose
    row and column are both even."""

    @property
    def grid(self) -> PixelGrid:
        """The sum of row and column is even; for a quarter, the row is even too."""
        return PixelGrid(2, 1 if self.share == "half" else 2)


class Lattice(_Grid, frozen=True, tag="lattice"):
    """A fixed set of points spread evenly over the unit disk, mapped by each ellipse.

    An ellipse costs the same whatever its size, and its histogram is an unbiased estimate of the
    one over every pixel. The target model, with which all ellipses are compared, is read once, by a
    denser lattice.
    """

    points: Annotated[int, Meta(ge=8, le=65536)] = 256
    """Number of pixels of an ellipse that are read, whatever its size. More pixels are more exact
    and slower."""

    @property
    def dense(self) -> Self:
        """The sampling that reads a target model: `DENSE` points, or more."""
        return replace(self, points=max(self.points, DENSE))

    @property
    def lattice(self) -> Singles:
        """The points in the unit disk, (2, points): rows u and v."""
        return sunflower(self.points)


Sampling = EveryPixel | Checkerboard | Lattice


class EllipsePixels(Config, frozen=True, dict=True):
    """The base of cues that weigh the pixels of an ellipse."""

    kernel: Profile = "epanechnikov"
    """Fall of a pixel's weight from the center of the ellipse to its border: `epanechnikov` to 0,
    `radial` to about 0.5, `gaussian` to 0.6, `uniform` not at all. `radial` is equation 2 of
    Nummiaro et al., `gaussian` equation 1 of Zhao and Pei."""
    sampling: Sampling = Lattice()
    """Which pixels of an ellipse are read: every one, a checkerboard, or a lattice of fixed
    size."""

    @cached_property
    def reading(self) -> Reading:
        """Kernel and sampling in the form that kernels of the compiled code take."""
        return Reading(self.sampling.lattice, self.sampling.grid, PROFILES[self.kernel])


@cache
def sunflower(points: int) -> Singles:
    """Return points (2, n) that cover the unit disk with equal area for each: rows u and v.

    Vogel's spiral: radius sqrt((i + 1/2) / n), angle i times the golden angle. Points are ordered
    in rows of the disk, so that successive pixels are near each other in memory.
    """
    i = np.arange(points)
    radius = np.sqrt((i + 0.5) / points)
    angle = i * np.pi * (3 - np.sqrt(5))
    u, v = radius * np.cos(angle), radius * np.sin(angle)
    rows = np.floor((v + 1) * np.sqrt(points) / 2)
    return np.stack([u, v])[:, np.lexsort((u, rows))].astype(np.float32, order="C")
