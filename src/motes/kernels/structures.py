"""The types of what kernels take: arrays, and the tuples that they read as structures."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

Bytes = NDArray[np.uint8]
Sums = NDArray[np.uint16]
Counts = NDArray[np.uint32]
Integers = NDArray[np.int32]
Singles = NDArray[np.float32]
Floats = NDArray[np.float64]
Spectra = NDArray[np.complex64]

Window = tuple[int, int, int, int, int, int]
"""A part of an image: left, top, width, height; steps in memory from a pixel, and a row, on."""
Box = tuple[float, float, float, float]
"""Left, top, right and bottom, in samples."""
Pair = tuple[float, float]
"""x and y."""
Place = tuple[float, float, float, float, float]
"""An ellipse: x, y, a, b and theta."""


class PixelGrid(NamedTuple):
    """Which pixels are read where there is no lattice; 1, 1 is every pixel."""

    across: int = 1
    """Row and column add up to a multiple of it."""
    down: int = 1
    """The row is a multiple of it."""


class Reading(NamedTuple):
    """How ellipses are read."""

    lattice: Singles
    """Points (2, n) in the unit disk; (2, 0) for the pixels of `grid`."""
    grid: PixelGrid
    """Without a lattice, which pixels are read."""
    profile: int
    """A number of `kernels.sampling`: how a pixel's weight falls with its distance."""


class NoiseScales(NamedTuple):
    """Random motion in one reference interval: `Noise` and `Walking` of `sot.filtering.motion`."""

    position: float
    size: float
    size_return: float
    aspect: float
    angle: float
    """As there."""
    changes: Floats
    """(k,), standard deviations of each order of changes, as shares of what they change."""
    persistence: float
    """Share of a change that is left."""


class ColorBins(NamedTuple):
    """A color space, by its number in `kernels.color`, and its bins in each channel."""

    space: int
    n0: int
    n1: int
    n2: int


class ColorTarget(NamedTuple):
    """A target's colors, and how ellipses are read that are compared with them."""

    reading: Reading
    """How ellipses are read."""
    slots: Counts
    """For each bin, its index among the occupied ones; their number if it is empty."""
    roots: Floats
    """Square roots of the occupied bins."""
    bins: ColorBins
    """The bins."""


class ColorComparison(NamedTuple):
    """What a filter on color alone compares particles with."""

    target: ColorTarget
    """The target."""
    likelihood: tuple[float, float]
    """Sigma and epsilon of `Gaussian`."""
    threshold: float
    """A particle appears with a rho above it."""
    ring: bool
    """Whether regions beside the estimate are read too."""


class PointCues(NamedTuple):
    """What is known of the points of a window, as offsets from its middle."""

    response: Singles
    """(h, w), responses of a filter."""
    step: float
    """From one response to the next."""
    integral: Floats
    """(H + 1, W + 1), sums of the color posterior, see `bilinear.box_means`."""
    core: Pair
    """Half sides of the box around a point whose colors count."""
    share: float
    """Weight of the colors; that of the response is the rest."""
    sigma: float
    """The log-weight of a point is what both say together, divided by it."""
    deviation: Pair
    """Standard deviations, across and down, with which the target is expected in the middle;
    infinite where it may be anywhere."""


class LightLimits(NamedTuple):
    """What another light may change; see `BackgroundConfig`."""

    shadow: float
    highlight: float
    tint: float
    texture: float


class HoldLimits(NamedTuple):
    """Seconds for which foreground is not learned; see `BackgroundConfig`."""

    trial: float
    patience: float


class MixtureLearning(NamedTuple):
    """How a mixture of Gaussians learns a picture."""

    rate: float
    """Share of the picture in the model from then on."""
    prune: float
    """A mode whose weight is smaller than this share of `rate` is removed."""
    near: float
    """Squared distance up to which a color is one of a mode, in its variances."""
    first: float
    least: float
    most: float
    """Variance of a new mode, and limits of all."""
