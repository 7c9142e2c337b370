"""The size of the target: a correlation filter over sizes instead of places.

Danelljan et al., Accurate scale estimation for robust visual tracking, BMVC 2014, section 3.
"""

from __future__ import annotations

from typing import Annotated

import msgspec
import numpy as np
from msgspec import Meta
from msgspec.structs import replace

from motes import kernels
from motes.core.config import Config
from motes.core.frame import Frame
from motes.core.geometry import Ellipse, as_ellipse
from motes.core.saved_state import SAME, NotNegativeSingles
from motes.core.types import Floats, Singles, Spectra
from motes.cues.fourier import irfft2, rfft
from motes.cues.fourier_ridge import (
    filtered,
    gaussian,
    half_frequencies,
    taper,
    updated,
    vertex,
)
from motes.cues.search_window import CELL_SIZE, sectors

SIDE = 32
"""Mean side of a target in samples; a target with fewer pixels has one sample to a pixel."""
SHARPNESS = 0.7
"""Standard deviation of the Gaussian that the filter learns, in steps from one size to the next."""
MOST_CELLS = 1024
"""Largest number of cells to a side, which only a line would exceed."""
RIDGE = 0.01
"""Energy that is added to every frequency, so that those of low energy have less influence."""


class ScaleModel(msgspec.Struct, frozen=True, eq=False, tag="sizes"):
    """A learned filter over sizes."""

    numerator: Spectra
    """(features, n // 2 + 1): conjugate label times features."""
    power: NotNegativeSingles
    """(n // 2 + 1,): energy of the features."""
    rows: Annotated[int, SAME]
    columns: Annotated[int, SAME]
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
        out: Floats = np.power(self.step, np.arange(self.count, dtype=np.float64) - self.count // 2)
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
            CELL_SIZE, sectors(), out,
        )  # fmt: skip
        return rfft(out)

    def response(self, model: ScaleModel, spectra: Spectra) -> Singles:
        """Return the filter's response at each size, (count,)."""
        learned = filtered(model.numerator, model.power + RIDGE, spectra)
        # The label's peak is at the first size; it belongs to the middle one.
        out: Singles = np.roll(irfft2(learned[None], self.count)[0], self.count // 2)
        return out

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
        label = gaussian(half_frequencies(self.count), SHARPNESS)
        numerator, power = updated(model.numerator, model.power, spectra, label, rate)
        return replace(model, numerator=numerator, power=power)
