"""A window around the target, sampled once: a fixed number of samples, whatever the target's size.

What is learned from a window can be compared with another one sample by sample, and costs the same
for a target of 8 pixels and of half the frame.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cache, cached_property

import numpy as np
from numpy.typing import NDArray

from motes import kernels
from motes.core.frame import Frame
from motes.core.geometry import Ellipse
from motes.core.types import Bytes, Floats, Singles
from motes.cues.base import visible

CELL_SIZE = 4
"""Samples to the side of a cell (Felzenszwalb et al., PAMI 2010, have 8; DSST and others 4)."""
SAMPLES = 128
"""Mean side of a window in samples."""
WIDEST = 2.5
"""The taper is no wider than so many of the target's sides: what is learned of a thin target would
be its surroundings else."""
FINEST = 2
"""No more samples than this to a pixel, which would show nothing new."""
LARGER = 1.3
"""From the size of one window of several to that of the next."""
TURN = 0.5
"""From the turn of one to that of the next, in radians."""


@dataclass(frozen=True, eq=False)
class Grid:
    """The samples around a target whose first region had a certain size.

    The window is the target with half of its mean side around it.

    Attributes
    ----------
    rows, columns
        Of cells.
    width, height
        The target's, in samples.
    """

    rows: int
    columns: int
    width: float
    height: float

    @cached_property
    def taper(self) -> Singles:
        """(rows, columns) Hann's window, which spares the transform the borders' jump."""
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
        """Return how many samples (N, 2) pixels lie off the center of a target's window."""
        cosine, sine = math.cos(ellipse.theta), math.sin(ellipse.theta)
        turned = (points - ellipse[:2]) @ np.array([[cosine, -sine], [sine, cosine]])
        out: Floats = turned / self.step(ellipse)
        return out

    def points(self, ellipse: Ellipse, offsets: Floats) -> Floats:
        """Return the pixels (N, 2) that lie so many samples off that center."""
        cosine, sine = math.cos(ellipse.theta), math.sin(ellipse.theta)
        steps = offsets * self.step(ellipse)
        out: Floats = steps @ np.array([[cosine, sine], [-sine, cosine]]) + ellipse[:2]
        return out

    def sample_window(self, frame: Frame, ellipse: Ellipse) -> Singles:
        """Return the samples (3, H, W) of the window around a target."""
        return cut(
            frame, ellipse, self.step(ellipse), (self.rows * CELL_SIZE, self.columns * CELL_SIZE)
        )

    def tile_windows(
        self, frame: Frame, place: Ellipse, ellipses: Floats
    ) -> Iterator[tuple[Ellipse, NDArray[np.intp]]]:
        """Yield windows that together see some ellipses (N, 5), each with the rows that it sees.

        Windows lie a target's side apart, and differ in size and turn by steps, all counted from
        `place`. So what is seen of an ellipse does not depend on the others, and where all are near
        to the target's last place, one window will do. No window sees an ellipse outside the frame,
        or one that is none.
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


def _hann(cells: int, side: float) -> Floats:
    """Return Hann's window of a row of cells, for a target with a side of so many samples."""
    offsets = np.arange(cells) - (cells - 1) / 2
    width = min(cells + 1, WIDEST * side / CELL_SIZE)
    return np.where(np.abs(offsets) < width / 2, 0.5 + 0.5 * np.cos(2 * np.pi * offsets / width), 0)


def cut(
    frame: Frame, ellipse: Ellipse, step: tuple[float, float], shape: tuple[int, int]
) -> Singles:
    """Return samples (3, H, W) around an ellipse, as it is turned, `step` pixels apart each way."""
    cosine, sine = math.cos(ellipse.theta), math.sin(ellipse.theta)
    across, down = (step[0] * cosine, step[0] * sine), (-step[1] * sine, step[1] * cosine)
    right, low = (shape[1] - 1) / 2, (shape[0] - 1) / 2
    corner = (
        ellipse.x - right * across[0] - low * down[0],
        ellipse.y - right * across[1] - low * down[1],
    )
    samples = np.empty((3, *shape), np.float32)
    kernels.search_window.cut(frame.pixels, corner, across, down, samples)
    return samples


@cache
def sectors() -> Bytes:
    """Return which of 18 sectors of the turn a gradient has, as `window.gradient_cells` asks."""
    dy, dx = np.mgrid[-256:256, -256:256]
    numbers = np.round(np.arctan2(dy, dx) * 9 / np.pi).astype(np.int64) % 18
    out: Bytes = numbers.astype(np.uint8)
    return out


def features(samples: Singles) -> Singles:
    """Return the features (30, h, w) of the cells of samples (3, H, W).

    Histograms of oriented gradients after Felzenszwalb et al., Object detection with
    discriminatively trained part-based models, PAMI 2010, section 6, without their texture
    features; gray and two color differences beside them.
    """
    out = np.empty((30, samples.shape[1] // CELL_SIZE, samples.shape[2] // CELL_SIZE), np.float32)
    kernels.search_window.gradient_cells(samples, CELL_SIZE, sectors(), out)
    return out


@cache
def grid(a: float, b: float) -> Grid:
    """Return the grid for a target whose half-axes were first a and b pixels."""
    width, height = 2 * a, 2 * b
    around = (width + height) / 2
    wide, high = width + around, height + around
    pixels = max(math.sqrt(wide * high) / SAMPLES, 1 / FINEST)
    columns, rows = (_fast(side / pixels / CELL_SIZE) for side in (wide, high))
    return Grid(rows, columns, width * columns * CELL_SIZE / wide, height * rows * CELL_SIZE / high)


def _fast(cells: float) -> int:
    """Return a number of cells near to one wanted whose transform is fast."""
    from scipy.fft import next_fast_len  # takes a third of a second to import

    return int(next_fast_len(max(round(cells), 6), real=True))
