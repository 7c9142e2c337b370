"""The place of the target: a correlation filter that is confined to the target, in a wide window.

Its filter is zero outside of the target's box, so that it learns the target and not what lies
around it, although it learns to tell the target from all of the window (Kiani Galoogahi et al.,
Learning background-aware correlation filters, ICCV 2017). A temporal term keeps it close to the
filter of the frame before, so that one wrong frame changes little (Li et al., Learning
spatial-temporal regularized correlation filters, CVPR 2018).
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cache
from typing import Annotated

import msgspec
import numpy as np
from msgspec import Meta
from msgspec.structs import replace

from motes import kernels
from motes.core.config import Config
from motes.core.frame import Frame
from motes.core.geometry import Ellipse, as_ellipse
from motes.core.types import Singles, Spectra
from motes.cues import fourier as ridge
from motes.cues.fourier import fast_length, irfft2, rfft2
from motes.cues.search_window import CELL_SIZE, cut, features

REACH = 5.0
"""Side of the window, in mean sides of the target. A larger one would find faster targets."""
SHARPNESS = 1 / 16
"""Width of the response's peak: standard deviation of the Gaussian that the filter learns, as a
share of the target's mean side."""
INERTIA = 15.0
"""Weight of the filter of the frame before: one wrong frame changes it little."""
ITERATIONS = 2
"""Iterations in which a new filter and its confinement come together; twice as many in the first
frame, as there is no filter before it."""
LEAST_SAMPLES, MOST_SAMPLES = 120, 200
"""Side of the window in samples: one to a pixel where that lies between these."""
FIRST_PENALTY, PENALTY = 1.0, 0.1
"""Weight of the confinement in the first iteration, and in the others."""
REFERENCE_FRAMES = 10
"""The mean response to the target in this many frames, from the start, is the reference."""
LEARNED_RESPONSE = 0.7
"""Until then: this share of the response to the very frame that was learned."""
SAME_SIZE = 0.08
"""A window serves for targets whose size differs by no more than this share."""
PEAK_RADIUS = 1.5
"""A target's response is the largest within this many standard deviations of the label."""


class ConfinedModel(msgspec.Struct, frozen=True, eq=False, tag="confined"):
    """A learned filter."""

    a: float
    b: float
    """Half-axes of the target's first region in pixels, from which the window follows."""
    filter: Spectra
    """(30, n, n // 2 + 1): the filter's transform."""
    reference: Annotated[float, Meta(ge=1e-6)]
    """The mean response to the target in the first frames."""
    seen: int
    """Number of these frames."""


@dataclass(frozen=True, eq=False)
class ConfinedGrid:
    """The window around a target: square, `cells` to a side."""

    cells: int
    """Number of cells to a side."""
    pixels: float
    """Pixels from one sample to the next at the target's first size."""
    target: float
    """The target's mean side in pixels at its first size."""
    wide: float
    high: float
    """The target's width and height in cells."""
    sigma: float
    """Standard deviation of the label, in cells."""

    @property
    def box(self) -> tuple[int, int]:
        """Columns and rows of cells in the middle in which the filter may differ from 0."""
        return max(round(self.wide), 2), max(round(self.high), 2)

    def step(self, place: Ellipse) -> float:
        """Return the pixels from one sample to the next for a target of another size."""
        return self.pixels * place.side / self.target

    def label(self, x: float, y: float) -> Spectra:
        """Return the conjugate transform (n, n // 2 + 1) of the response that is to be learned.

        It is a Gaussian at the target, x, y cells off the center.
        """
        down = ridge.gaussian(ridge.frequencies(self.cells), self.sigma, y)
        across = ridge.gaussian(ridge.half_frequencies(self.cells), self.sigma, x)
        out: Spectra = np.outer(down, across).astype(np.complex64)
        return out


@dataclass(frozen=True, eq=False)
class ConfinedView:
    """What the filter sees in a frame, in a window around one place."""

    place: Ellipse
    """The ellipse at the window's center."""
    pixels: float
    """Pixels from one sample to the next."""
    spectra: Spectra
    """(30, n, n // 2 + 1): the transform of the window's features."""
    plane: Singles
    """(CELL_SIZE n, CELL_SIZE n): the response at each sample, relative to that in the first
    frames."""
    radius: float
    """Within this many pixels of a place, the largest response is that of the place."""

    def covers(self, place: Ellipse) -> bool:
        """Return whether the window also serves for a target elsewhere."""
        off = math.hypot(place.x - self.place.x, place.y - self.place.y)
        return (
            place.theta == self.place.theta
            and abs(math.log(place.side / self.place.side)) < SAME_SIZE
            and off < (REACH / 2 - 1) * self.place.side
        )

    def offset(self, place: Ellipse) -> tuple[float, float]:
        """Return how far a place is from the window's center, in cells along its sides."""
        cosine, sine = math.cos(self.place.theta), math.sin(self.place.theta)
        x, y = place.x - self.place.x, place.y - self.place.y
        size = self.pixels * CELL_SIZE
        return (cosine * x + sine * y) / size, (cosine * y - sine * x) / size

    def peak(self) -> Ellipse:
        """Return where in the window the response is largest."""
        rows, columns = self.plane.shape
        row, column = divmod(int(np.argmax(self.plane)), columns)
        x, y = self.pixels * (column - columns // 2), self.pixels * (row - rows // 2)
        cosine, sine = math.cos(self.place.theta), math.sin(self.place.theta)
        return self.place._replace(
            x=self.place.x + cosine * x - sine * y, y=self.place.y + sine * x + cosine * y
        )

    def near(self, place: Ellipse) -> float:
        """Return the largest response within `radius` of a place; 0 outside of the window."""
        across, down = self.offset(place)
        size = len(self.plane)
        column, row = (round(off * CELL_SIZE) + size // 2 for off in (across, down))
        if not (0 <= row < size and 0 <= column < size):
            return 0.0
        reach = max(round(self.radius / self.pixels), CELL_SIZE)
        top, left = max(row - reach, 0), max(column - reach, 0)
        return float(self.plane[top : row + reach + 1, left : column + reach + 1].max())


class ConfinedFilter(Config, frozen=True):
    """Correlation filter in a wide window, zero outside of the target's box."""

    def learn(self, frame: Frame, ellipse: Ellipse) -> ConfinedModel:
        """Return the filter of the window around `ellipse`."""
        ellipse = as_ellipse(ellipse)
        grid = _grid(ellipse.a, ellipse.b)
        spectra = self._spectra(grid, frame, ellipse)
        learned = self._solve(grid, spectra, None, grid.label(0.0, 0.0), 0.0)
        model = ConfinedModel(ellipse.a, ellipse.b, learned, 1.0, 0)
        response = self.view(model, frame, ellipse).near(ellipse)
        return replace(model, reference=max(LEARNED_RESPONSE * response, 1e-6))

    def view(self, model: ConfinedModel, frame: Frame, place: Ellipse) -> ConfinedView:
        """Return what the filter sees around a place, in a target's size and angle there."""
        grid = _grid(model.a, model.b)
        spectra = self._spectra(grid, frame, place)
        n = grid.cells
        response = ridge.filtered(model.filter, np.ones((n, n // 2 + 1), np.float32), spectra)
        side = CELL_SIZE * n
        padded = np.zeros((side, n // 2 + 1), np.complex64)
        low, high = (n + 1) // 2, n // 2
        padded[:low], padded[side - high :] = response[:low], response[low:]
        plane = irfft2(padded, side)
        plane *= CELL_SIZE**2 / model.reference
        pixels = grid.step(place)
        radius = PEAK_RADIUS * grid.sigma * CELL_SIZE * pixels
        return ConfinedView(place, pixels, spectra, ridge.centered(plane), radius)

    def updated(
        self,
        model: ConfinedModel,
        frame: Frame,
        view: ConfinedView,
        target: Ellipse,
        share: float = 1.0,
    ) -> ConfinedModel:
        """Return the filter after it has learned from a frame.

        `share` is how much of the frame is learned, from 0: the inertia is divided by it. 1 is a
        frame, and `INERTIA` gives it the weight of all before.
        """
        if not share:
            return model
        grid, spectra = _grid(model.a, model.b), view.spectra
        x, y = view.offset(target)
        near = math.hypot(x, y) < 0.4 * math.sqrt(grid.wide * grid.high)
        if not (near and view.covers(target)):
            spectra, x, y = self._spectra(grid, frame, target), 0.0, 0.0
        learned = self._solve(grid, spectra, model.filter, grid.label(x, y), INERTIA / share)
        seen, reference = model.seen, model.reference
        if seen < REFERENCE_FRAMES:
            response = view.near(target) * reference
            reference = max((seen * reference + response) / (seen + 1), 1e-6)
            seen += 1
        return replace(model, filter=learned, reference=reference, seen=seen)

    def learn_also(self, model: ConfinedModel, frame: Frame, ellipse: Ellipse) -> ConfinedModel:
        """Return the filter that has also learned another frame, with the weight of all before."""
        return self.updated(model, frame, self.view(model, frame, ellipse), ellipse, INERTIA)

    def _spectra(self, grid: ConfinedGrid, frame: Frame, place: Ellipse) -> Spectra:
        """Return the transform (30, n, n // 2 + 1) of the window's tapered features."""
        place = as_ellipse(place)
        side, step = grid.cells * CELL_SIZE, grid.step(place)
        cells = features(cut(frame, place, (step, step), (side, side)))
        energy = float(np.vdot(cells, cells))
        gain = np.float32(math.sqrt(cells.size / (energy + 1e-6)))
        cells *= ridge.taper(grid.cells, grid.cells) * gain
        return rfft2(cells)

    def _solve(
        self,
        grid: ConfinedGrid,
        spectra: Spectra,
        before: Spectra | None,
        label: Spectra,
        inertia: float,
    ) -> Spectra:
        """Return the filter of a window by alternating directions (Li et al., equations 6 to 9).

        The filter is learned for all of the window, its copy is confined to the target, and a
        multiplier makes them alike. `before` is the filter of the frame before, with a weight of
        `inertia`.
        """
        rounds = 2 * ITERATIONS if before is None else ITERATIONS
        before = np.zeros_like(spectra) if before is None else before
        learned = np.empty_like(spectra)
        kernels.fourier_ridge.alternate(
            spectra, label, before, inertia, (FIRST_PENALTY, PENALTY), rounds, *grid.box, learned
        )
        return learned


@cache
def _grid(a: float, b: float) -> ConfinedGrid:
    """Return the window of a target whose half-axes were first a and b pixels."""
    target = 2 * math.sqrt(a * b)
    samples = min(max(REACH * target, LEAST_SAMPLES), MOST_SAMPLES)
    cells = fast_length(round(samples / CELL_SIZE))
    pixels = REACH * target / (cells * CELL_SIZE)
    wide, high = (2 * half / pixels / CELL_SIZE for half in (a, b))
    return ConfinedGrid(cells, pixels, target, wide, high, SHARPNESS * math.sqrt(wide * high))
