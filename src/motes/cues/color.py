"""Color histograms under a weighting kernel, compared by the Bhattacharyya distance.

Nummiaro et al., section III.
"""

from __future__ import annotations

import math
from functools import cached_property
from typing import Annotated, Literal

import numpy as np
from msgspec import Meta
from msgspec.structs import replace
from numpy.typing import NDArray

from motes import kernels
from motes.core.frame import Frame
from motes.core.geometry import Ellipse
from motes.core.types import Floats
from motes.cues.histogram_cue import HistogramCue, HistogramModel
from motes.cues.sampling import PROFILES, Lattice, Profile, Sampling
from motes.kernels.structures import ColorBins, Reading

Bins = Annotated[int, Meta(ge=1, le=64)]

SPACES = {"rgb": kernels.color.RGB, "hsv": kernels.color.HSV, "hsv+v": kernels.color.HSV_V}


class ColorModel(HistogramModel, frozen=True, eq=False, dict=True, tag="color"):
    """A target's color histogram."""

    @cached_property
    def roots(self) -> Floats:
        """Square roots of the occupied bins, in order; the others add nothing to equation 6."""
        return np.sqrt(self.histogram[self.histogram > 0])

    @cached_property
    def slots(self) -> NDArray[np.uint32]:
        """For each bin, its place among the occupied ones, or their number where it is empty."""
        occupied = self.histogram > 0
        count = np.count_nonzero(occupied)
        slots = np.full(occupied.size, count, np.uint32)
        slots[occupied] = np.arange(count, dtype=np.uint32)
        return slots


class Color(HistogramCue, frozen=True):
    """Weighted color histogram of an ellipse (equations 2 to 7).

    Attributes
    ----------
    space
        `rgb` or `hsv`; or `hsv+v`, where a pixel with color falls into a bin of hue and saturation,
        and one without into one of value alone: Zhao and Pei, section 2.1. They do not say when a
        pixel has color; Perez et al. (ECCV 2002), from whom they have it: where saturation is above
        0.1 and value above 0.2.
    bins
        Number of bins in each channel: 8x8x8 for RGB, 8x8x4 for HSV, 8x8+8 for `hsv+v`.
    kernel
        How pixels are weighted: `radial` is equation 2; see `sampling.Profile`.
    sampling
        Which pixels are read.
    """

    space: Literal["rgb", "hsv", "hsv+v"] = "rgb"
    bins: tuple[Bins, Bins, Bins] = (8, 8, 8)
    kernel: Profile = "radial"
    sampling: Sampling = Lattice()

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
        m = self.size
        histograms = np.empty((len(ellipses), m))
        slots = np.arange(m, dtype=np.uint32)
        kernels.color.histograms(
            frame.pixels, ellipses, self._reading, slots, self._bins, histograms
        )
        return histograms

    def learn(self, frame: Frame, ellipse: Ellipse) -> ColorModel:
        """Return the target model of the region in `ellipse`, read as `sampling.dense` says."""
        cue = replace(self, sampling=self.sampling.dense)
        histogram = cue.histograms(frame, np.array([ellipse]))[0]
        return ColorModel(histogram, histogram)

    def distances(self, model: ColorModel, frame: Frame, ellipses: Floats) -> Floats:
        """Return the Bhattacharyya distance of each ellipse (N, 5) to the model, shape (N,)."""
        distances = np.empty(len(ellipses))
        kernels.color.distances(
            frame.pixels,
            ellipses,
            self._reading,
            model.slots,
            model.roots,
            self._bins,
            distances,
        )
        return distances

    def shift(self, model: ColorModel, frame: Frame, ellipse: Ellipse) -> tuple[float, float]:
        """Return where one mean-shift iteration moves the ellipse's center.

        The mean of its pixels, each weighted by sqrt(q / p) of its bin, q the model's and p the
        region's histogram; exact for the Epanechnikov kernel. Comaniciu, Ramesh and Meer, Real-time
        tracking of non-rigid objects using mean shift, CVPR 2000, equations 10 and 11.
        """
        region = np.array(ellipse)
        seen = self.histograms(frame, region[None])[0][model.histogram > 0]
        ratios = np.zeros(seen.size + 1)
        np.divide(model.roots, np.sqrt(seen), out=ratios[:-1], where=seen > 0)
        center = region[:2].copy()
        kernels.color.mean_shift(
            frame.pixels, region, self.sampling.lattice, self.sampling.grid, model.slots, ratios,
            self._bins, center,
        )  # fmt: skip
        return float(center[0]), float(center[1])

    @property
    def _reading(self) -> Reading:
        return Reading(self.sampling.lattice, self.sampling.grid, PROFILES[self.kernel])

    @property
    def _bins(self) -> ColorBins:
        return ColorBins(SPACES[self.space], *self.bins)
