"""Color histograms under a weighting kernel, compared by the Bhattacharyya distance.

Nummiaro et al., section III.
"""

from __future__ import annotations

import math
from functools import cached_property
from typing import Annotated, Literal

import numpy as np
from msgspec import Meta
from numpy.typing import NDArray

from motes import kernels
from motes.core.frame import Frame
from motes.core.geometry import Ellipse, as_ellipse, as_ellipses
from motes.core.types import Floats
from motes.cues.base import check_bins
from motes.cues.histogram_cue import HistogramModel, PixelHistogramCue
from motes.cues.sampling import Profile
from motes.kernels.structures import ColorBins, ColorTarget

Bins = Annotated[int, Meta(ge=1, le=64)]

SPACES = {"rgb": kernels.color.RGB, "hsv": kernels.color.HSV, "hsv+v": kernels.color.HSV_V}


class ColorModel(HistogramModel, frozen=True, eq=False, dict=True, tag="color"):
    """A target's color histogram."""

    @cached_property
    def roots(self) -> Floats:
        """Square roots of the occupied bins, in order; empty bins add nothing to equation 6."""
        return np.sqrt(self.histogram[self.histogram > 0])

    @cached_property
    def slots(self) -> NDArray[np.uint32]:
        """For each bin, its index among the occupied bins; their number if it is empty."""
        occupied = self.histogram > 0
        count = np.count_nonzero(occupied)
        slots = np.full(occupied.size, count, np.uint32)
        slots[occupied] = np.arange(count, dtype=np.uint32)
        return slots


class Color(PixelHistogramCue, frozen=True):
    """Weighted color histogram of an ellipse: Nummiaro et al., equations 2 to 7."""

    space: Literal["rgb", "hsv", "hsv+v"] = "rgb"
    """Color space of the histogram. With `rgb` and `hsv` it has three dimensions. With `hsv+v`, a
    pixel with color falls into a bin of hue and saturation, any other into a bin of value alone
    (Zhao and Pei, section 2.1). A pixel has color if its saturation is above 0.1 and its value
    above 0.2 (Perez et al., ECCV 2002)."""
    bins: tuple[Bins, Bins, Bins] = (8, 8, 8)
    """Number of bins of each channel: 8x8x8 for `rgb`, 8x8x4 for `hsv`, 8x8 + 8 for `hsv+v`. More
    bins separate more colors, but the histogram changes more with the light."""
    kernel: Profile = "radial"

    model_type = ColorModel

    @property
    def size(self) -> int:
        """Number of bins of a histogram, m."""
        if self.space == "hsv+v":
            return self.bins[0] * self.bins[1] + self.bins[2]
        return math.prod(self.bins)

    def histograms(self, frame: Frame, ellipses: Floats) -> Floats:
        """Return the histogram of each ellipse (equation 3).

        Parameters
        ----------
        frame
            The picture.
        ellipses
            (N, 5): x, y, a, b, theta.

        Returns
        -------
        (N, m); each row sums to 1, or is zero where the ellipse lies outside the frame.
        """
        m, ellipses = self.size, as_ellipses(ellipses)
        histograms = np.empty((len(ellipses), m))
        slots = np.arange(m, dtype=np.uint32)
        kernels.color.histograms(
            frame.pixels, ellipses, self.reading, slots, self._bins, histograms
        )
        return histograms

    def distances(self, model: ColorModel, frame: Frame, ellipses: Floats) -> Floats:
        """Return the Bhattacharyya distance of each ellipse (N, 5) to the model, shape (N,)."""
        ellipses = as_ellipses(ellipses)
        distances = np.empty(len(ellipses))
        kernels.color.distances(frame.pixels, ellipses, self.target(model), distances)
        return distances

    def target(self, model: ColorModel) -> ColorTarget:
        """Return what kernels need to compare ellipses with a model."""
        check_bins(model, self.size)
        return ColorTarget(self.reading, model.slots, model.roots, self._bins)

    def shift(self, model: ColorModel, frame: Frame, ellipse: Ellipse) -> tuple[float, float]:
        """Return the ellipse's center after one mean-shift iteration.

        It is the mean of the ellipse's pixels. The weight of a pixel is sqrt(q / p) of its bin,
        with the model's histogram q and the region's p. This is exact for the Epanechnikov kernel.
        Comaniciu, Ramesh and Meer, Real-time
        tracking of non-rigid objects using mean shift, CVPR 2000, equations 10 and 11.
        """
        check_bins(model, self.size)
        region = np.array(as_ellipse(ellipse))
        seen = self.histograms(frame, region[None])[0][model.histogram > 0]
        ratios = np.zeros(seen.size + 1)
        np.divide(model.roots, np.sqrt(seen), out=ratios[:-1], where=seen > 0)
        center = region[:2].copy()
        kernels.color.mean_shift(
            frame.pixels, region, self.sampling.lattice, self.sampling.grid, model.slots, ratios,
            self._bins, center,
        )  # fmt: skip
        return float(center[0]), float(center[1])

    @cached_property
    def _bins(self) -> ColorBins:
        return ColorBins(SPACES[self.space], *self.bins)
