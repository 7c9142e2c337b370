"""Histograms of edge orientation from the structure tensor, compared by the Bhattacharyya distance.

Maggio, Smeraldi and Cavallaro, Combining colour and orientation for adaptive particle filter-based
tracking, BMVC 2005, section 3.2.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import lru_cache
from typing import Annotated, Literal, NamedTuple

import msgspec
import numpy as np
from msgspec import Meta

from motes import kernels
from motes.core.config import Share
from motes.core.frame import Frame
from motes.core.geometry import Ellipse, as_ellipse, as_ellipses
from motes.core.types import Floats, Singles
from motes.cues.base import AdaptableCue, HistogramModel, bhattacharyya, check_bins
from motes.cues.gradients import Plane, blocks, plane_over
from motes.cues.sampling import PROFILES, EllipsePixels

FINEST = 0.7
"""Least scale in pixels: a narrower derivative filter is too coarse when sampled at pixels."""
COARSEST = 0.9
"""Least scale in blocks, where blocks of several pixels can be chosen."""
WIDEST = 1000.0
"""Largest scale in pixels: wider filters would need more memory than pictures do."""
HYSTERESIS = 0.1
"""Share by which the target's size must change before the filters' scale follows."""


class OrientationModel(HistogramModel, frozen=True, eq=False, tag="orientation"):
    """A target's orientation histogram, and the filters that read the next frame."""

    scale: Annotated[float, Meta(ge=FINEST, le=WIDEST)]
    """Standard deviation of the derivative filter, in pixels."""
    threshold: float
    """T; pixels with a certainty up to this value are left out."""


class Filters(NamedTuple):
    """The filters of one scale, on a grid of blocks of pixels; taps at 0 … r."""

    step: int
    """Side of a block in pixels. Coarse filters need no fine grid."""
    smooth: Singles
    derivative: Singles
    """A Gaussian and its first derivative."""
    window: Singles
    """The Gaussian that averages the tensor, omega in equation 3."""


@dataclass(frozen=True, slots=True, eq=False)
class CertainPlane(Plane):
    """Orientation (equation 5) with its certainty C (equation 4), (H, W)."""

    certainty: Singles


class Orientation(AdaptableCue, EllipsePixels, frozen=True):
    """Histogram of the orientation of edges in an ellipse, weighted by their certainty."""

    bins: Annotated[int, Meta(ge=4, le=180)] = 36
    """Number of bins over half a turn, [-pi/2, pi/2): opposite directions count as one. More bins
    separate smaller angles."""
    form: Literal["rotated", "fourier"] = "rotated"
    """How the histogram is made independent of the target's rotation. `rotated` (ROH) shifts it by
    the ellipse's angle, also by fractions of a bin. `fourier` (FOH) takes the magnitudes of its
    Fourier transform."""
    scale: Annotated[float, Meta(gt=0, le=1)] = 0.05
    """Standard deviation of the derivative filter, as a share of the target's mean half-axis sqrt(a
    b). A larger value reads coarser edges."""
    window: Annotated[float, Meta(ge=0.01, le=8)] = 1.0
    """Standard deviation of the Gaussian that averages the structure tensor, as a multiple of the
    derivative filter's. A larger value averages over more pixels."""
    scale_selection: bool = True
    """If true, the filter's scale follows the target's size (SS); if false, that of the first frame
    stays. In the paper the scale parameter, a variance, is proportional to the target's area."""
    kept_fraction: Share = 0.5
    """Share of the target's pixels that count: those with the highest certainty of their
    orientation. It sets the threshold T. A larger value counts weaker edges too."""

    def learn(self, frame: Frame, ellipse: Ellipse) -> OrientationModel:
        """Return the target model of the region in `ellipse`, read with `sampling.dense`."""
        ellipse = as_ellipse(ellipse)
        scale = self._scale(ellipse)
        threshold = self._threshold(frame, scale, ellipse)
        cue = msgspec.structs.replace(self, sampling=self.sampling.dense)
        histogram = cue._histograms(frame, scale, threshold, np.array([ellipse], float))[0]
        return OrientationModel(histogram, histogram, scale, threshold)

    def distances(self, model: OrientationModel, frame: Frame, ellipses: Floats) -> Floats:
        """Return the Bhattacharyya distance of each ellipse (N, 5) to the model, shape (N,)."""
        seen = self._histograms(frame, model.scale, model.threshold, ellipses)
        check_bins(model, seen.shape[1])
        return bhattacharyya(seen, model.histogram)

    def observe(self, model: OrientationModel, frame: Frame, ellipse: Ellipse) -> Floats:
        """Return the region's histogram, (m,), read as the model's; zeros if there is no edge."""
        region = np.array([ellipse], float)
        histogram: Floats = self._histograms(frame, model.scale, model.threshold, region)[0]
        return histogram

    def update_reading(
        self, model: OrientationModel, frame: Frame, ellipse: Ellipse
    ) -> OrientationModel:
        """Return the model with scale and threshold for the next frame, from the target's region.

        Section 3.2: T is set by the distribution of C over the target in the previous frame.
        Section 3.2.2: the scale follows the target's size, here in steps (`HYSTERESIS`).
        """
        scale, ellipse = model.scale, as_ellipse(ellipse)
        if self.scale_selection:
            wanted = self._scale(ellipse)
            if abs(wanted - scale) > HYSTERESIS * scale:
                scale = wanted
        threshold = self._threshold(frame, scale, ellipse)
        return msgspec.structs.replace(model, scale=scale, threshold=threshold)

    def _scale(self, ellipse: Ellipse) -> float:
        return min(max(FINEST, self.scale * math.sqrt(ellipse.a * ellipse.b)), WIDEST)

    def _threshold(self, frame: Frame, scale: float, ellipse: Ellipse) -> float:
        """Return T, above which the share `kept_fraction` of the ellipse's pixels lies."""
        region = np.array([ellipse], float)
        plane = self._plane(frame, scale, region)
        seen = kernels.sampling.values_within(
            plane.certainty, plane.column, plane.row, plane.in_blocks(region)[0],
            self.reading._replace(profile=PROFILES["uniform"]),
        )  # fmt: skip
        below = int((1 - self.kept_fraction) * seen.size)
        if below == 0:  # all are kept, or the ellipse lies outside the frame
            return -1.0
        return float(np.partition(seen, below - 1)[below - 1])

    def _histograms(self, frame: Frame, scale: float, threshold: float, ellipses: Floats) -> Floats:
        """Return the histogram of each ellipse, or its spectrum; zeros where there is no edge."""
        ellipses = as_ellipses(ellipses)
        plane = self._plane(frame, scale, ellipses)
        shifts = np.zeros(len(ellipses))
        if self.form == "rotated":
            shifts = ellipses[:, 4] * (self.bins / np.pi)
        histograms = np.empty((len(ellipses), self.bins))
        kernels.structure_tensor.histograms(
            plane.certainty,
            plane.bins,
            plane.column,
            plane.row,
            plane.in_blocks(ellipses),
            self.reading,
            threshold,
            shifts,
            histograms,
        )
        if self.form == "rotated":
            return histograms
        spectra = np.abs(np.fft.rfft(histograms, axis=1))
        sums = spectra.sum(axis=1, keepdims=True)
        out: Floats = np.divide(spectra, sums, out=np.zeros_like(spectra), where=sums > 0)
        return out

    def _plane(self, frame: Frame, scale: float, ellipses: Floats) -> CertainPlane:
        """Return a plane that covers the ellipses."""
        filters = filters_of(scale, self.window)

        def compute(column: int, row: int, shape: tuple[int, int]) -> CertainPlane:
            step = filters.step
            plane = CertainPlane(
                column, row, step, np.empty(shape, np.uint8), np.empty(shape, np.float32)
            )
            kernels.structure_tensor.structure_tensor(
                frame.pixels, column * step, row * step, *filters,
                plane.certainty, plane.bins, self.bins,
            )  # fmt: skip
            return plane

        key = ("orientation", scale, self.window, self.bins)
        return plane_over(frame, blocks(frame, ellipses, filters.step), key, compute)


@lru_cache(maxsize=64)
def filters_of(scale: float, window: float) -> Filters:
    """Return the filters of a scale in pixels; `window` is the averaging's scale over it.

    A block is as large as the scale allows, so that a large target costs no more than a small one.
    Averaging over blocks is part of the smoothing: its variance is taken from the Gaussian's.
    """
    step = max(1, int(scale / COARSEST))
    sigma = math.sqrt((scale / step) ** 2 - (1 - step**-2) / 12)
    smooth = _gaussian(sigma)
    k = np.arange(len(smooth))
    derivative = smooth * k
    derivative /= 2 * np.sum(derivative * k)  # a slope of one gives one
    averaging = _gaussian(scale / step * window)
    return Filters(step, *(taps.astype(np.float32) for taps in (smooth, derivative, averaging)))


def _gaussian(sigma: float) -> Floats:
    """Return a Gaussian's taps at 0 … r; with those at -r … -1 they sum to 1."""
    taps = np.exp(-0.5 * (np.arange(math.ceil(2.5 * sigma) + 1) / sigma) ** 2)
    normalized: Floats = taps / (2 * taps.sum() - taps[0])
    return normalized
