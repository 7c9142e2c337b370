"""Where is what was learned: a correlation filter over cells of gradients and colors.

Ridge regression from the window around the target onto a Gaussian at its center, for all shifts of
the window at once, in the Fourier domain (Bolme et al., CVPR 2010; Danelljan et al., Accurate scale
estimation for robust visual tracking, BMVC 2014, equations 3 to 5).
"""

from __future__ import annotations

import math

import msgspec
import numpy as np
from msgspec.structs import replace
from numpy.typing import NDArray
from scipy import fft

from motes import kernels
from motes.config import Config, Positive, Share
from motes.cues.window import CELL, Grid, Singles, features, grid
from motes.frame import Frame
from motes.geometry import Ellipse

Floats = NDArray[np.float64]
Spectra = NDArray[np.complex64]


class CorrelationModel(msgspec.Struct, frozen=True, eq=False, tag="correlation"):
    """A learned filter, numerator over power, and the one of the first frame.

    Attributes
    ----------
    numerator, first_numerator
        (30, h, w // 2 + 1): conjugate label times features.
    power, first_power
        (h, w // 2 + 1): energy of the features.
    a, b
        Half-axes of the target's first region, from which the grid follows.
    """

    numerator: Spectra
    power: Singles
    first_numerator: Spectra
    first_power: Singles
    a: float
    b: float

    @property
    def grid(self) -> Grid:
        """The samples that the filter reads."""
        return grid(self.a, self.b)


class Correlation(Config, frozen=True):
    """The cue: 1 - response of the filter.

    Attributes
    ----------
    sharpness
        Standard deviation of the label, as a share of the target's mean side.
    ridge
        Energy below which a frequency has little say.
    anchor
        Share of the first frame's filter in the response, whatever was learned since.
    """

    sharpness: Positive = 1 / 12
    ridge: Positive = 1.0
    anchor: Share = 0.3

    def learn(self, frame: Frame, ellipse: Ellipse) -> CorrelationModel:
        """Return the filter of the window around `ellipse`."""
        box = ellipse.box
        a, b = box.width / 2, box.height / 2
        numerator, power = self.lesson(self.spectra(grid(a, b), frame, ellipse), grid(a, b))
        return CorrelationModel(numerator, power, numerator, power, a, b)

    def distances(self, model: CorrelationModel, frame: Frame, ellipses: Floats) -> Floats:
        """Return 1 - response at each ellipse (N, 5), in the window around their mean, (N,)."""
        place = Ellipse(*ellipses.mean(axis=0).tolist())
        plane = self.response(model, self.spectra(model.grid, frame, place))
        return 1 - np.clip(at(plane, model.grid, place, ellipses), 0, 1)

    def spectra(self, samples: Grid, frame: Frame, ellipse: Ellipse) -> Spectra:
        """Return the transform (30, h, w // 2 + 1) of the tapered features around `ellipse`."""
        out: Spectra = fft.rfft2(features(samples.cut(frame, ellipse)) * samples.taper)
        return out

    def lesson(
        self, spectra: Spectra, samples: Grid, x: float = 0.0, y: float = 0.0
    ) -> tuple[Spectra, Singles]:
        """Return numerator and power for a target x, y samples off the window's center."""
        down, across = np.fft.fftfreq(samples.rows)[:, None], np.fft.rfftfreq(samples.columns)
        sigma = self.sharpness * math.sqrt(samples.width * samples.height) / CELL
        # The transform of a Gaussian is one; its conjugate is shifted the other way.
        label = np.exp(-2 * (np.pi * sigma) ** 2 * (down**2 + across**2)) * 2 * np.pi * sigma**2
        label = label * np.exp(2j * np.pi * (y * down + x * across) / CELL)
        power: Singles = (spectra.real**2 + spectra.imag**2).sum(axis=0)
        return label.astype(np.complex64) * spectra, power

    def taught(
        self, model: CorrelationModel, spectra: Spectra, rate: float, x: float = 0.0, y: float = 0.0
    ) -> CorrelationModel:
        """Return the filter with a share `rate` of what a window says, target x, y off center."""
        numerator, power = self.lesson(spectra, model.grid, x, y)
        return replace(
            model,
            numerator=(1 - rate) * model.numerator + rate * numerator,
            power=(1 - rate) * model.power + rate * power,
        )

    def response(self, model: CorrelationModel, spectra: Spectra) -> Singles:
        """Return the filter's response (H, W), one value a sample, 1 being the label's peak.

        The first frame's filter has its share. The inverse transform is padded with zeros, and so
        as fine as the samples.
        """
        learned = np.einsum("kij,kij->ij", model.numerator.conj(), spectra)
        mixed = (1 - self.anchor) * learned / (model.power + self.ridge)
        if self.anchor:
            mixed += self.anchor * self._first(model, spectra)
        samples = model.grid
        height, width = samples.rows * CELL, samples.columns * CELL
        padded = np.zeros((height, width // 2 + 1), np.complex64)
        half = samples.rows // 2
        padded[: samples.rows - half, : mixed.shape[1]] = mixed[: samples.rows - half]
        padded[height - half :, : mixed.shape[1]] = mixed[samples.rows - half :]
        plane = fft.irfft2(padded, (height, width)) * CELL**2
        out: Singles = np.roll(plane, (height // 2, width // 2), (0, 1))
        return out

    def first(
        self, model: CorrelationModel, spectra: Spectra, x: float = 0.0, y: float = 0.0
    ) -> float:
        """Return the response of the first frame's filter, best within a cell of a place.

        The place is x, y samples off the window's center.
        """
        plane = fft.irfft2(self._first(model, spectra), (model.grid.rows, model.grid.columns))
        near = np.arange(-1, 2)
        rows, columns = (near + round(off / CELL) for off in (y, x))
        return float(plane[np.ix_(rows % len(plane), columns % plane.shape[1])].max())

    def _first(self, model: CorrelationModel, spectra: Spectra) -> Spectra:
        learned = np.einsum("kij,kij->ij", model.first_numerator.conj(), spectra)
        out: Spectra = learned / (model.first_power + self.ridge)
        return out


def at(plane: Singles, samples: Grid, place: Ellipse, ellipses: Floats) -> Floats:
    """Return a response (H, W) of the window around `place` at the ellipses' centers, (N,)."""
    step_x, step_y = samples.step(place)
    left, top = (
        place.x - plane.shape[1] // 2 * step_x,
        place.y - plane.shape[0] // 2 * step_y,
    )
    out = np.empty(len(ellipses))
    kernels.look_up(plane, ellipses, (left, top), (step_x, step_y), out)
    return out
