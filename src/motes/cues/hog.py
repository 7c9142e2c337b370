"""Histograms of oriented gradients, compared by the Bhattacharyya distance.

Zhao and Pei, Model update particle filter for multiple objects detection and tracking, section 2.1.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated

import numpy as np
from msgspec import Meta
from msgspec.structs import replace

from motes import kernels
from motes.core.frame import Frame
from motes.core.geometry import Ellipse
from motes.core.types import Floats, Singles
from motes.cues.feature_maps import Plane, blocks, plane_over
from motes.cues.histogram_cue import HistogramCue, HistogramModel
from motes.cues.sampling import PROFILES, Lattice, Profile, Sampling
from motes.kernels.structures import Reading

SMOOTH = np.array([0.75, 0.125, 0], np.float32)
"""Taps at 0, 1 and 2, to both sides: of variance 0.25, delta = 0.5 of section 4, and exact in
single precision, so that a gradient is the same whichever part it is computed with."""
DERIVATIVE = np.array([0, 0.375, 0.0625], np.float32)
"""Those of half the difference of the neighbors, smoothed; negative on the other side."""
AT_POINTS = 5
"""Gradients cost so many times as much at scattered points as all over a region."""


class HogModel(HistogramModel, frozen=True, eq=False, tag="hog"):
    """A target's histogram of oriented gradients, cell by cell; zeros without any gradient."""


@dataclass(frozen=True, slots=True, eq=False)
class GradientPlane(Plane):
    """Direction of the gradient, with its strength: (H, W)."""

    strength: Singles


class Hog(HistogramCue, frozen=True):
    """Histogram of the directions of gradients in an ellipse, turned to the strongest one (2).

    As in SIFT (Lowe, IJCV 2004), which the paper follows, a pixel counts by the strength of its
    gradient: equation 2 as printed has the weights of equation 1 alone, by which the noise of a
    smooth surface would count as much as an edge; but it calls its result a magnitude. Directions
    cover a whole turn, so that dark on bright is not bright on dark.

    Attributes
    ----------
    cells
        Rows, and columns, of cells, each with a histogram of its own; all are turned alike. 1 gives
        the 8 bins of the paper's experiments; 3 the 72 by which it tells targets of one color
        apart. Cells divide the box around the ellipse, and turn with it, not with the strongest
        direction, which may change from frame to frame.
    bins
        Over a whole turn, in each cell.
    rotation_normalized
        Whether a histogram is turned so that its strongest direction comes first, the others
        following around the circle: a target that turns then keeps its histogram, to half a bin.
        Without, one that stays upright is told better from others.
    kernel
        How pixels are weighted, by their place in the ellipse; `gaussian` is equation 1.
    sampling
        Which of them are read.
    """

    cells: Annotated[int, Meta(ge=1, le=4)] = 1
    bins: Annotated[int, Meta(ge=2, le=16)] = 8
    rotation_normalized: bool = True
    kernel: Profile = "gaussian"
    sampling: Sampling = Lattice()

    def histograms(self, frame: Frame, ellipses: Floats) -> Floats:
        """Return the histogram of each ellipse (N, 5), shape (N, cells² bins).

        Each row sums to 1, or is zero where the ellipse sees no gradient.
        """
        histograms = np.empty((len(ellipses), self.cells**2 * self.bins))
        lattice, profile = self.sampling.lattice, PROFILES[self.kernel]
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
            Reading(lattice, self.sampling.grid, profile),
            self.cells,
            self.rotation_normalized,
            histograms,
        )
        return histograms

    def learn(self, frame: Frame, ellipse: Ellipse) -> HogModel:
        """Return the target model of the region in `ellipse`, read as `sampling.dense` says."""
        cue = replace(self, sampling=self.sampling.dense)
        histogram = cue.histograms(frame, np.array([ellipse]))[0]
        return HogModel(histogram, histogram)
