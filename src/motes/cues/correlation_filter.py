"""Correlation filters over cells of gradients and colors: the place of the target, and its size.

The place is found by ridge regression from the window around the target onto a Gaussian at its
center, for all shifts of the window at once, in the Fourier domain: Bolme et al., CVPR 2010;
Danelljan et al., Accurate scale estimation for robust visual tracking, BMVC 2014, equations 3 to 5.
The size is found by the same regression over sizes instead of places (section 3).
"""

from __future__ import annotations

import math
from functools import cache
from typing import Annotated

import msgspec
import numpy as np
from msgspec import Meta
from msgspec.structs import replace
from numpy.typing import NDArray

from motes import kernels
from motes.core.config import Config, Positive, Share
from motes.core.frame import Frame
from motes.core.geometry import Ellipse, as_ellipse, as_ellipses
from motes.core.types import Floats, Singles, Spectra
from motes.cues.base import Cue
from motes.cues.fourier import (
    centered,
    filtered,
    frequencies,
    gaussian,
    half_frequencies,
    irfft2,
    rfft,
    rfft2,
    taper,
    updated,
    vertex,
)
from motes.cues.search_window import CELL_SIZE, SampleGrid, WindowModel, features, grid_of, sectors

RIDGE = 1.0
"""Energy that is added to every frequency, so that those of low energy have less influence."""
UPSAMPLING = 2
"""Number of a response's values per side of a cell."""


class CorrelationModel(WindowModel, frozen=True, eq=False, tag="correlation"):
    """A learned filter, numerator over power, and the filter of the first frame.

    Attributes
    ----------
    numerator, first_numerator
        (30, h, w // 2 + 1): conjugate label times features.
    power, first_power
        (h, w // 2 + 1): energy of the features.
    """

    numerator: Spectra
    power: Singles
    first_numerator: Spectra
    first_power: Singles


class Correlation(Cue, Config, frozen=True):
    """Correlation filter over gradients and colors, updated while the target is present.

    The distance is 1 - response of the filter.
    """

    sharpness: Positive = 1 / 12
    """Width of the response's peak: standard deviation of the Gaussian that the filter learns, as a
    share of the target's mean side. A larger value gives a wider peak."""
    anchor: Share = 0.3
    """Share of the first frame's filter in the response; the rest is that of the learned filter.
    With a larger value the target's first appearance counts more."""
    learning_rate: Share = 0.02
    """Share of the current frame in the updated filter. With a larger value the filter follows
    changes faster; 0 keeps it fixed."""

    def learn(self, frame: Frame, ellipse: Ellipse) -> CorrelationModel:
        """Return the filter of the window around `ellipse`."""
        ellipse = as_ellipse(ellipse)
        grid = grid_of(ellipse.a, ellipse.b)
        spectra = self.spectra(grid, grid.sample_window(frame, ellipse))
        numerator, power = np.zeros_like(spectra), np.zeros(spectra.shape[1:], np.float32)
        model = CorrelationModel(ellipse.a, ellipse.b, ellipse, numerator, power, numerator, power)
        model = self.updated(model, spectra, 1.0)
        return replace(model, first_numerator=model.numerator, first_power=model.power)

    def distances(self, model: CorrelationModel, frame: Frame, ellipses: Floats) -> Floats:
        """Return 1 - response at each ellipse (N, 5), in a window near it, (N,)."""
        grid, ellipses = model.grid, as_ellipses(ellipses)
        out = np.zeros(len(ellipses))
        for place, mine in grid.tile_windows(frame, model.place, ellipses):
            plane, _ = self.responses(model, self.spectra(grid, grid.sample_window(frame, place)))
            out[mine] = sample_response(plane, grid.offsets(place, ellipses[mine, :2]))
        return 1 - np.clip(out, 0, 1)

    def update_reading(
        self, model: CorrelationModel, frame: Frame, ellipse: Ellipse
    ) -> CorrelationModel:
        """Return the filter updated with a target in `ellipse`."""
        spectra = self.spectra(model.grid, model.grid.sample_window(frame, ellipse))
        return replace(self.updated(model, spectra, self.learning_rate), place=ellipse)

    def learn_also(
        self, model: CorrelationModel, frame: Frame, ellipse: Ellipse
    ) -> CorrelationModel:
        """Return the filter of both windows, as of Bolme et al.'s; the first frame's stays."""
        spectra = self.spectra(model.grid, model.grid.sample_window(frame, ellipse))
        return self.updated(model, spectra, 0.5)

    def spectra(self, grid: SampleGrid, window: Singles) -> Spectra:
        """Return the transform (30, h, w // 2 + 1) of a window's features (3, H, W), tapered."""
        cells = features(window)
        cells *= grid.taper
        return rfft2(cells)

    def updated(
        self, model: CorrelationModel, spectra: Spectra, rate: float, x: float = 0.0, y: float = 0.0
    ) -> CorrelationModel:
        """Return the filter moved by a share `rate` towards a window, given by its spectra.

        The target is x, y samples off the window's center.
        """
        grid = model.grid
        rows, columns = frequencies(grid.rows), half_frequencies(grid.columns)
        sigma = self.sharpness * math.sqrt(grid.width * grid.height) / CELL_SIZE
        label = np.outer(
            gaussian(rows, sigma, y / CELL_SIZE), gaussian(columns, sigma, x / CELL_SIZE)
        )
        numerator, power = updated(model.numerator, model.power, spectra, label, rate)
        return replace(model, numerator=numerator, power=power)

    def responses(self, model: CorrelationModel, spectra: Spectra) -> tuple[Singles, Singles]:
        """Return the filter's response and that of the first frame's filter, around the middle.

        The label's peak is 1. The first frame's filter has the share `anchor` in the filter's
        response. That response has shape (UPSAMPLING h, UPSAMPLING w): there are UPSAMPLING values
        to a cell's side, by an inverse transform padded with zeros. The second response (h, w) has
        one value to a cell.
        """
        first = filtered(model.first_numerator, model.first_power + RIDGE, spectra)
        learned = filtered(model.numerator, model.power + RIDGE, spectra)
        rows, columns = model.grid.rows, model.grid.columns
        padded = np.empty((UPSAMPLING * rows, UPSAMPLING * columns // 2 + 1), np.complex64)
        kernels.fourier_ridge.pad(learned, first, self.anchor, UPSAMPLING**2, padded)
        plane = irfft2(padded, UPSAMPLING * columns)
        return centered(plane), centered(irfft2(first, columns))


def sample_response(plane: Singles, points: Floats) -> Floats:
    """Return a response at points (N, 2), in samples off the window's center, (N,)."""
    out = np.empty(len(points))
    kernels.bilinear.look_up(plane, points, CELL_SIZE / UPSAMPLING, out)
    return out


def peak_near(first: Singles, x: float, y: float) -> float:
    """Return the first filter's largest response within a cell of x, y samples off the center."""
    row, column = (
        size // 2 + round(off / CELL_SIZE) for size, off in zip(first.shape, (y, x), strict=True)
    )
    near = first[max(row - 1, 0) : row + 2, max(column - 1, 0) : column + 2]
    return float(near.max(initial=0.0))


SIDE = 32
"""Mean side of a target in samples; a target with fewer pixels has one sample to a pixel."""
SHARPNESS = 0.7
"""Standard deviation of the Gaussian that the filter learns, in steps from one size to the next."""
MOST_CELLS = 1024
"""Largest number of cells to a side, which only a line would exceed."""
SIZE_RIDGE = 0.01
"""Energy that is added to every frequency of the filter over sizes."""


class ScaleModel(msgspec.Struct, frozen=True, eq=False, tag="sizes"):
    """A learned filter over sizes."""

    numerator: Spectra
    """(features, n // 2 + 1): conjugate label times features."""
    power: Singles
    """(n // 2 + 1,): energy of the features."""
    rows: int
    columns: int
    """Number of rows and of columns of the target's cells."""


class ScaleFilter(Config, frozen=True):
    """Correlation filter over several sizes around the last one."""

    count: Annotated[int, Meta(ge=1, le=33)] = 13
    """Number of sizes that are compared. More sizes follow faster growth and take more time."""
    step: Annotated[float, Meta(gt=1, le=2)] = 1.06
    """Factor from one size to the next. A larger value follows faster growth, in coarser steps."""

    @property
    def factors(self) -> Floats:
        """(count,), the compared sizes as factors of the last one."""
        steps = np.arange(self.count, dtype=np.float64) - self.count // 2
        out: Floats = np.power(self.step, steps)
        return out

    def learn(self, frame: Frame, ellipse: Ellipse) -> ScaleModel:
        """Return the filter of a target in an ellipse."""
        ellipse = as_ellipse(ellipse)
        shrink = min(1.0, SIDE / ellipse.side)
        rows, columns = (
            min(max(round(2 * half * shrink / CELL_SIZE), 2), MOST_CELLS)
            for half in (ellipse.b, ellipse.a)
        )
        nothing = np.zeros((30 * rows * columns, self.count // 2 + 1), np.complex64)
        model = ScaleModel(nothing, np.zeros(nothing.shape[1], np.float32), rows, columns)
        return self.updated(model, self.spectra(model, frame, ellipse), 1.0)

    def spectra(self, model: ScaleModel, frame: Frame, ellipse: Ellipse) -> Spectra:
        """Return the transform over sizes (features, count // 2 + 1) of a target's cells."""
        ellipse = as_ellipse(ellipse)
        out = np.empty((len(model.numerator), self.count), np.float32)
        kernels.search_window.cells_of_sizes(
            frame.pixels, ellipse, self.factors, taper(1, self.count)[0], model.rows, model.columns,
            sectors(), out,
        )  # fmt: skip
        return rfft(out)

    def response(self, model: ScaleModel, spectra: Spectra) -> Singles:
        """Return the filter's response at each size, (count,)."""
        learned = filtered(model.numerator, model.power + SIZE_RIDGE, spectra)
        values, half = irfft2(learned[None], self.count)[0], self.count - self.count // 2
        # The label's peak is at the first size; it belongs to the middle one.
        return np.concatenate([values[half:], values[:half]])

    def between(self, values: Floats) -> float:
        """Return the factor at the maximum of values (count,), by a parabola through its neighbors.

        Without a neighbor to either side it is the factor of the largest value.
        """
        best = int(np.argmax(values))
        if not 0 < best < len(values) - 1:
            return float(self.factors[best])
        shift = vertex(*values[best - 1 : best + 2].tolist())
        return float(self.factors[best] * self.step**shift)

    def updated(self, model: ScaleModel, spectra: Spectra, rate: float) -> ScaleModel:
        """Return the filter moved by a share `rate` towards a target, given by its spectra."""
        label = _label(self.count)
        numerator, power = updated(model.numerator, model.power, spectra, label, rate)
        return replace(model, numerator=numerator, power=power)


@cache
def _label(count: int) -> NDArray[np.complex128]:
    """Return the conjugate transform (count // 2 + 1,) of the label over sizes."""
    return gaussian(half_frequencies(count), SHARPNESS)
