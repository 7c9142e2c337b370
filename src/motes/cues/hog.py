"""Histograms of oriented gradients, compared by the Bhattacharyya distance.

Zhao and Pei, Model update particle filter for multiple objects detection and tracking, section 2.1.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated

import numpy as np
from msgspec import Meta

from motes import kernels
from motes.core.frame import Frame
from motes.core.geometry import as_ellipses
from motes.core.types import Floats, Singles
from motes.cues.feature_maps import Plane, blocks, plane_over
from motes.cues.histogram_cue import PixelHistogramCue
from motes.cues.sampling import Profile

SMOOTH = np.array([0.75, 0.125, 0], np.float32)
"""Smoothing filter: taps at 0, 1 and 2, to both sides.

Its variance is 0.25, delta = 0.5 of section 4. The taps are exact in single precision, so that a
gradient is the same in whatever part of the frame it is computed.
"""
DERIVATIVE = np.array([0, 0.375, 0.0625], np.float32)
"""Smoothed derivative filter: taps at 0, 1 and 2; those on the other side are negative."""
AT_POINTS = 5
"""Cost of a gradient at a scattered point, relative to a pixel of a whole region."""


@dataclass(frozen=True, slots=True, eq=False)
class GradientPlane(Plane):
    """Direction of the gradient, with its strength: (H, W)."""

    strength: Singles


class Hog(PixelHistogramCue, frozen=True):
    """Histogram of the directions of gradients in an ellipse: Zhao and Pei, section 2.1.

    As in SIFT (Lowe, IJCV 2004), which the paper follows, a pixel counts by the strength of its
    gradient. The printed equation 2 has the weights of equation 1 alone, but calls its result a
    magnitude; with these weights the noise of a smooth surface would count as much as an edge.
    Directions cover a whole turn, so that dark on bright differs from bright on dark.
    """

    cells: Annotated[int, Meta(ge=1, le=4)] = 1
    """Number of rows, and of columns, of cells. Each cell has its own histogram; all are rotated by
    the same angle. More cells separate targets better, but are more sensitive to deformation. The
    paper's experiments have 1 cell with 8 bins; its 72 bins are 3x3 cells. Cells divide the box
    around the ellipse and turn with it, not with the strongest direction, which may change between
    frames."""
    bins: Annotated[int, Meta(ge=2, le=16)] = 8
    """Number of bins over a whole turn, in each cell. More bins separate smaller angles."""
    rotation_normalized: bool = True
    """If true, a histogram is rotated so that its strongest direction comes first: a target that
    turns keeps its histogram, up to half a bin. If false, a target that stays upright is separated
    better from others."""
    kernel: Profile = "gaussian"

    def histograms(self, frame: Frame, ellipses: Floats) -> Floats:
        """Return the histogram of each ellipse (N, 5), shape (N, cells² bins).

        Each row sums to 1, or is zero if there is no gradient in the ellipse.
        """
        ellipses = as_ellipses(ellipses)
        histograms = np.empty((len(ellipses), self.cells**2 * self.bins))
        lattice, _, profile = self.reading
        part = left, top, right, bottom = blocks(frame, ellipses, 1)
        if 0 < AT_POINTS * len(ellipses) * lattice.shape[1] < (right - left) * (bottom - top):
            kernels.hog.histograms_at(
                frame.pixels, ellipses, lattice, profile, self.cells,
                self.rotation_normalized, SMOOTH, DERIVATIVE, histograms,
            )  # fmt: skip
            return histograms

        def compute(column: int, row: int, shape: tuple[int, int]) -> GradientPlane:
            plane = GradientPlane(
                column, row, 1, np.empty(shape, np.uint8), np.empty(shape, np.float32)
            )
            kernels.hog.gradients(
                frame.pixels, column, row, SMOOTH, DERIVATIVE, plane.strength, plane.bins, self.bins
            )
            return plane

        plane = plane_over(frame, part, ("hog", self.bins), compute)
        kernels.hog.histograms(
            plane.strength,
            plane.bins,
            plane.column,
            plane.row,
            ellipses,
            self.reading,
            self.cells,
            self.rotation_normalized,
            histograms,
        )
        return histograms
