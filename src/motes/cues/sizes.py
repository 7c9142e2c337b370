"""How large is the target? A correlation filter over sizes instead of places.

Danelljan et al., Accurate scale estimation for robust visual tracking, BMVC 2014, section 3.
"""

from __future__ import annotations

import math

import msgspec
import numpy as np
from msgspec.structs import replace
from numpy.typing import NDArray
from scipy import fft

from motes.config import Config, NonNegative, Positive
from motes.cues.window import CELL, Singles, cut, features
from motes.frame import Frame
from motes.geometry import Ellipse

Spectra = NDArray[np.complex64]

SIDE = 32
"""Mean side of a target in samples; a smaller one has as many as it has pixels."""


class SizeModel(msgspec.Struct, frozen=True, eq=False, tag="sizes"):
    """A learned filter.

    Attributes
    ----------
    numerator
        (n // 2 + 1, features): conjugate label times features.
    power
        (n // 2 + 1,): energy of the features.
    rows, columns
        Of the target's cells.
    """

    numerator: Spectra
    power: Singles
    rows: int
    columns: int


class Sizes(Config, frozen=True):
    """The target at several sizes around the last one.

    Attributes
    ----------
    count, step
        How many sizes, and the factor from one to the next. Finer steps miss fast growth.
    sharpness
        Standard deviation of the label, in steps.
    ridge
        Energy below which a frequency has little say.
    """

    count: int = 13
    step: Positive = 1.06
    sharpness: Positive = 0.7
    ridge: NonNegative = 0.01

    @property
    def factors(self) -> NDArray[np.float64]:
        """(count,), the sizes as factors of the last one."""
        out: NDArray[np.float64] = np.power(
            self.step, np.arange(self.count, dtype=np.float64) - self.count // 2
        )
        return out

    def learn(self, frame: Frame, ellipse: Ellipse) -> SizeModel:
        """Return the filter of a target in an ellipse."""
        shrink = min(1.0, SIDE / (2 * math.sqrt(ellipse.a * ellipse.b)))
        rows, columns = (max(round(2 * half * shrink / CELL), 2) for half in (ellipse.b, ellipse.a))
        numerator, power = self._lesson(self._spectra(rows, columns, frame, ellipse))
        return SizeModel(numerator, power, rows, columns)

    def _spectra(self, rows: int, columns: int, frame: Frame, ellipse: Ellipse) -> Spectra:
        """Return the transform over sizes (count // 2 + 1, features) of a target's cells."""
        shape = rows * CELL, columns * CELL
        out = np.empty((self.count, 30 * rows * columns), np.float32)
        for n, factor in enumerate(self.factors.tolist()):
            step = 2 * ellipse.a * factor / shape[1], 2 * ellipse.b * factor / shape[0]
            out[n] = features(cut(frame, ellipse, step, shape)).ravel()
        taper = np.hanning(self.count + 2)[1:-1].astype(np.float32)
        transform: Spectra = fft.rfft(out * taper[:, None], axis=0)
        return transform

    def response(self, model: SizeModel, frame: Frame, ellipse: Ellipse) -> Singles:
        """Return the filter's response at each size of a target, (count,)."""
        spectra = self._spectra(model.rows, model.columns, frame, ellipse)
        learned = (model.numerator.conj() * spectra).sum(axis=1) / (model.power + self.ridge)
        out: Singles = np.roll(fft.irfft(learned, self.count), self.count // 2)
        return out

    def taught(self, model: SizeModel, frame: Frame, ellipse: Ellipse, rate: float) -> SizeModel:
        """Return the filter with a share `rate` of the target in an ellipse."""
        numerator, power = self._lesson(self._spectra(model.rows, model.columns, frame, ellipse))
        return replace(
            model,
            numerator=(1 - rate) * model.numerator + rate * numerator,
            power=(1 - rate) * model.power + rate * power,
        )

    def _lesson(self, spectra: Spectra) -> tuple[Spectra, Singles]:
        frequency = np.fft.rfftfreq(self.count)
        sigma = self.sharpness
        label = np.exp(-2 * (np.pi * sigma * frequency) ** 2) * math.sqrt(2 * np.pi) * sigma
        # Its peak is at the first size; the middle one is meant, as `response` undoes.
        label = label.astype(np.complex64)
        power: Singles = (spectra.real**2 + spectra.imag**2).sum(axis=1)
        return label[:, None] * spectra, power
