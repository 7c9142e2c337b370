"""Histograms of edges and of oriented gradients, compared by the Bhattacharyya distance.

Their features are dense, over the part of a frame that ellipses cover, computed once a frame. Ng
and Delp, New models for real-time tracking using particle filtering, sections 3.2 to 3.4; Zhao and
Pei, Model update particle filter for multiple objects detection and tracking, section 2.1.
"""

from __future__ import annotations

from collections.abc import Callable, Hashable
from dataclasses import dataclass
from typing import Annotated, TypeVar

import numpy as np
from msgspec import Meta

from motes import kernels
from motes.core.frame import Frame
from motes.core.geometry import as_ellipses
from motes.core.types import Bytes, Floats, Singles
from motes.cues.base import PixelHistogramCue
from motes.cues.sampling import Profile


@dataclass(frozen=True, slots=True, eq=False)
class Plane:
    """The orientation of edges over a part of a frame, one for each block of pixels."""

    column: int
    row: int
    """Column and row of the first block."""
    step: int
    """Side of a block in pixels."""
    bins: Bytes
    """(H, W), number of each block's bin of orientation."""

    def in_blocks(self, ellipses: Floats) -> Floats:
        """Return ellipses (N, 5) in units of blocks."""
        out = ellipses.copy()
        out[:, :2] = (out[:, :2] + 0.5) / self.step - 0.5
        out[:, 2:4] /= self.step
        return out

    def covers(self, part: tuple[int, int, int, int]) -> bool:
        """Return whether it has the blocks `part`, as `blocks` returns them."""
        left, top, right, bottom = part
        height, width = self.bins.shape
        return (
            self.column <= left
            and self.row <= top
            and right <= self.column + width
            and bottom <= self.row + height
        )


P = TypeVar("P", bound=Plane)


def plane_over(
    frame: Frame,
    part: tuple[int, int, int, int],
    key: Hashable,
    compute: Callable[[int, int, tuple[int, int]], P],
) -> P:
    """Return a plane that covers a part (see `blocks`); the frame keeps the plane under `key`.

    `compute` makes a plane from the first column and row of its blocks, and its shape.
    """
    plane: P | None = frame.cache.get(key)
    if plane is None or not plane.covers(part):
        left, top, right, bottom = part
        plane = frame.cache[key] = compute(left, top, (bottom - top, right - left))
    return plane


def blocks(frame: Frame, ellipses: Floats, step: int) -> tuple[int, int, int, int]:
    """Return the blocks that ellipses cover: first column and row, and those after the last.

    Ellipses with NaN or infinity cover none; there is always one block.
    """
    columns, rows = -(-frame.width // step), -(-frame.height // step)
    ends = kernels.sampling.bounds(ellipses)
    if ends[0] > ends[2]:
        return 0, 0, 1, 1
    # A pixel reaches from half a pixel before its center to half a pixel behind it.
    left, top, right, bottom = (int((end + 0.5) // step) for end in ends)
    first, above = min(max(left, 0), columns - 1), min(max(top, 0), rows - 1)
    last, below = min(max(right, first), columns - 1), min(max(bottom, above), rows - 1)
    return first, above, last + 1, below + 1


SOBEL_AT_POINTS = 3
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
        if 0 < SOBEL_AT_POINTS * len(ellipses) * lattice.shape[1] < (right - left) * (bottom - top):
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


SMOOTH = np.array([0.75, 0.125, 0], np.float32)
"""Smoothing filter: taps at 0, 1 and 2, to both sides.

Its variance is 0.25, delta = 0.5 of section 4. The taps are exact in single precision, so that a
gradient is the same in whatever part of the frame it is computed.
"""
DERIVATIVE = np.array([0, 0.375, 0.0625], np.float32)
"""Smoothed derivative filter: taps at 0, 1 and 2; those on the other side are negative."""
HOG_AT_POINTS = 5
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
        if 0 < HOG_AT_POINTS * len(ellipses) * lattice.shape[1] < (right - left) * (bottom - top):
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
