"""Histograms of edge orientation by Sobel's operator, compared by the Bhattacharyya distance.

Ng and Delp, New models for real-time tracking using particle filtering, sections 3.2 to 3.4.
"""

from __future__ import annotations

from typing import Annotated

import numpy as np
from msgspec import Meta

from motes import kernels
from motes.core.frame import Frame
from motes.core.geometry import as_ellipses
from motes.core.types import Floats
from motes.cues.feature_maps import Plane, blocks, plane_over
from motes.cues.histogram_cue import PixelHistogramCue

AT_POINTS = 3
"""Cost of Sobel's operator at a scattered point, relative to a pixel of a whole region."""


class Edges(PixelHistogramCue, frozen=True):
    """Histogram of the orientation of strong edges in an ellipse: Ng and Delp, sections 3.2 to 3.4.

    Equations 10 to 15, 18 and 19. A pixel whose edge is no stronger than the threshold is left out;
    equation 14 would count it as angle 0. Any other pixel counts with its weight under the kernel,
    whatever its strength. Equation 15 divides by the number of bins, where the number of pixels is
    meant; here the sum of weights divides (equation 19).

    Two regions without any strong edge have distance 0. Such a region has distance 1 from any
    region with a strong edge.
    """

    threshold: Annotated[float, Meta(ge=0, le=1e4)] = 100.0
    """Strength above which an edge counts (Ng and Delp, equation 12). A straight edge between two
    gray values, 0 to 255, has four times their difference. A larger value counts fewer edges."""
    bins: Annotated[int, Meta(ge=2, le=180)] = 8
    """Number k of bins over half a turn (equation 13): opposite directions count as one. More bins
    separate smaller angles. The paper gives no number. The first bin is centered on horizontal
    edges, and one of an even number on vertical edges: noise then rarely moves these two, the most
    frequent ones, to another bin."""

    def histograms(self, frame: Frame, ellipses: Floats) -> Floats:
        """Return the histogram of each ellipse (N, 5), shape (N, k + 1).

        Each row sums to 1, or is zero where the ellipse lies outside the frame; its last place is 1
        where there is no strong edge.
        """
        ellipses = as_ellipses(ellipses)
        histograms = np.empty((len(ellipses), self.bins + 1))
        lattice, _, profile = self.reading
        part = left, top, right, bottom = blocks(frame, ellipses, 1)
        if 0 < AT_POINTS * len(ellipses) * lattice.shape[1] < (right - left) * (bottom - top):
            kernels.sobel.histograms_at(
                frame.pixels, ellipses, lattice, profile, self.threshold, histograms
            )
            return histograms

        def compute(column: int, row: int, shape: tuple[int, int]) -> Plane:
            plane = Plane(column, row, 1, np.empty(shape, np.uint8))
            kernels.sobel.sobel(frame.pixels, column, row, self.threshold, self.bins, plane.bins)
            return plane

        key = ("edges", self.threshold, self.bins)
        plane = plane_over(frame, part, key, compute)
        kernels.sobel.histograms(
            plane.bins, plane.column, plane.row, ellipses, self.reading, histograms
        )
        return histograms
