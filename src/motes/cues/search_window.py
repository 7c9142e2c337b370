"""A window around the target, sampled once: a fixed number of samples, whatever the target's size.

Two windows can be compared sample by sample. A window costs the same for a target of 8 pixels and
for one of half the frame.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cache, cached_property

import msgspec
import numpy as np
from numpy.typing import NDArray

from motes import kernels
from motes.core.frame import Frame
from motes.core.geometry import Ellipse, as_ellipse
from motes.core.types import Bytes, Floats, Singles
from motes.cues.base import visible
from motes.cues.fourier import fast_length

CELL_SIZE = kernels.search_window.CELL
"""Side of a cell in samples (Felzenszwalb et al., PAMI 2010, have 8; DSST and others 4)."""
SAMPLES = 128
"""Mean side of a window in samples."""
WIDEST = 2.5
"""Largest width of the taper, in sides of the target.

A wider taper would learn little but the surroundings of a thin target.
"""
FINEST = CELL_SIZE
"""Largest number of samples per pixel, in x and in y: then a cell has the size of a pixel."""
LEAST_MARGIN = 8
"""Smallest margin of a window, in pixels: however small the target is, the camera shakes by some
pixels."""
LARGER = 1.3
"""Ratio of the sizes of neighboring windows, if several are needed."""
TURN = 0.5
"""Difference of the angles of neighboring windows, in radians."""


@dataclass(frozen=True, eq=False)
class SampleGrid:
    """The samples around a target; their number follows from the size of its first region.

    The window is the target with a margin of half of its mean side, and of `LEAST_MARGIN` at least.
    """

    rows: int
    columns: int
    """Number of rows and of columns of cells."""
    width: float
    height: float
    """The target's width and height, in samples."""

    @cached_property
    def taper(self) -> Singles:
        """Hann's window (rows, columns): features fall to 0 at the borders of the transform."""
        down, across = _hann(self.rows, self.height), _hann(self.columns, self.width)
        return np.outer(down, across).astype(np.float32)

    @property
    def center(self) -> tuple[float, float]:
        """Column and row of the window's center, the target's, in samples."""
        return (self.columns * CELL_SIZE - 1) / 2, (self.rows * CELL_SIZE - 1) / 2

    @property
    def half(self) -> tuple[float, float]:
        """The target's half sides, in samples."""
        return self.width / 2, self.height / 2

    def step(self, ellipse: Ellipse) -> tuple[float, float]:
        """Return the pixels from one sample to the next, in x and y, for a target of a size."""
        return 2 * ellipse.a / self.width, 2 * ellipse.b / self.height

    def offsets(self, ellipse: Ellipse, points: Floats) -> Floats:
        """Return the offsets (N, 2) of pixels (N, 2) from a window's center, in samples."""
        cosine, sine = math.cos(ellipse.theta), math.sin(ellipse.theta)
        turned = (points - ellipse[:2]) @ np.array([[cosine, -sine], [sine, cosine]])
        out: Floats = turned / self.step(ellipse)
        return out

    def points(self, ellipse: Ellipse, offsets: Floats) -> Floats:
        """Return the pixels (N, 2) at offsets (N, 2) from a window's center, in samples."""
        cosine, sine = math.cos(ellipse.theta), math.sin(ellipse.theta)
        steps = offsets * self.step(ellipse)
        out: Floats = steps @ np.array([[cosine, sine], [-sine, cosine]]) + ellipse[:2]
        return out

    def sample_window(self, frame: Frame, ellipse: Ellipse) -> Singles:
        """Return the samples (3, H, W) of the window around a target."""
        ellipse = as_ellipse(ellipse)
        return cut(
            frame, ellipse, self.step(ellipse), (self.rows * CELL_SIZE, self.columns * CELL_SIZE)
        )

    def tile_windows(
        self, frame: Frame, place: Ellipse, ellipses: Floats
    ) -> Iterator[tuple[Ellipse, NDArray[np.intp]]]:
        """Yield windows that together cover ellipses (N, 5), each with the rows that it covers.

        Windows lie a target's side apart, and differ in size and angle by fixed steps. All are
        counted from `place`, so that the window of an ellipse does not depend on the other
        ellipses. One window is enough if all ellipses are near the target's last place. No window
        covers an ellipse outside the frame, or with NaN.
        """
        rows = np.flatnonzero(visible(frame, ellipses))
        if not rows.size:
            return
        ellipses = ellipses[rows]
        sides = np.array((self.width, self.height))
        numbers = np.empty((len(ellipses), 5))
        numbers[:, :2] = self.offsets(place, ellipses[:, :2]) / sides
        numbers[:, 2:4] = np.log(ellipses[:, 2:4] / place[2:4]) / math.log(LARGER)
        half_turn = (ellipses[:, 4] - place.theta + np.pi / 2) % np.pi - np.pi / 2
        numbers[:, 4] = half_turn / TURN
        steps, which, counts = np.unique(
            np.rint(numbers), axis=0, return_inverse=True, return_counts=True
        )
        own = np.split(np.argsort(which.ravel(), kind="stable"), np.cumsum(counts)[:-1])
        centers = self.points(place, steps[:, :2] * sides)
        halves = place[2:4] * LARGER ** steps[:, 2:4]
        turns = place.theta + TURN * steps[:, 4]
        for row, mine in zip(np.column_stack([centers, halves, turns]).tolist(), own, strict=True):
            yield Ellipse(*row), rows[mine]


class WindowModel(msgspec.Struct, frozen=True, eq=False):
    """The base of target models that are learned in a window around the target."""

    a: float
    b: float
    """Half-axes of the target's first region in pixels, from which the grid follows."""
    place: Ellipse
    """The target's last place, where the model was updated. `distances` reads the window there
    first."""

    @property
    def grid(self) -> SampleGrid:
        """The samples of the window around the target."""
        return grid_of(self.a, self.b)


def _hann(cells: int, side: float) -> Floats:
    """Return Hann's window of a row of cells; `side` is the target's side in samples."""
    offsets = np.arange(cells) - (cells - 1) / 2
    width = min(cells + 1, WIDEST * side / CELL_SIZE)
    return np.where(np.abs(offsets) < width / 2, 0.5 + 0.5 * np.cos(2 * np.pi * offsets / width), 0)


def cut(
    frame: Frame, ellipse: Ellipse, step: tuple[float, float], shape: tuple[int, int]
) -> Singles:
    """Return samples (3, H, W) around an ellipse, in its directions, `step` pixels apart."""
    samples = np.empty((3, *shape), np.float32)
    kernels.search_window.cut_around(frame.pixels, ellipse, step, samples)
    return samples


@cache
def sectors() -> Bytes:
    """Return the sector, of 18 of a whole turn, of each gradient (dy, dx), for `gradient_cells`."""
    steps = np.arange(257.0)
    right = np.round(np.arctan2(steps[:, None], steps) * 9 / np.pi).astype(np.int8)
    left = np.where(steps > 0, 9 - right, right)  # a vertical one is to neither side
    down = np.hstack([left[:, :0:-1], right[:, :-1]])
    out: Bytes = (np.vstack([-down[:0:-1], down[:-1]]) % 18).astype(np.uint8)
    return out


def features(samples: Singles) -> Singles:
    """Return the features (30, h, w) of the cells of samples (3, H, W).

    Histograms of oriented gradients after Felzenszwalb et al., Object detection with
    discriminatively trained part-based models, PAMI 2010, section 6, without their texture
    features; gray and two color differences beside them.
    """
    out = np.empty((30, samples.shape[1] // CELL_SIZE, samples.shape[2] // CELL_SIZE), np.float32)
    kernels.search_window.gradient_cells(samples, sectors(), out)
    return out


@cache
def grid_of(a: float, b: float) -> SampleGrid:
    """Return the grid for a target whose half-axes were first a and b pixels."""
    width, height = 2 * a, 2 * b
    around = max((width + height) / 2, 2 * LEAST_MARGIN)
    wide, high = width + around, height + around
    pixels = max(math.sqrt(wide * high) / SAMPLES, 1 / FINEST)
    # The Fourier transform is fast on these numbers of cells.
    columns, rows = (fast_length(max(round(side / pixels / CELL_SIZE), 6)) for side in (wide, high))
    return SampleGrid(
        rows, columns, width * columns * CELL_SIZE / wide, height * rows * CELL_SIZE / high
    )
