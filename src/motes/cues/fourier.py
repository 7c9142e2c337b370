"""Fourier transforms of real signals in single precision, and ridge regression with them.

`scipy.fft` has the same transforms, and takes a third of a second to import. The regression is of a
label on signals and all their cyclic shifts: Bolme et al., Visual object tracking using adaptive
correlation filters, CVPR 2010; Danelljan et al., Accurate scale estimation for robust visual
tracking, BMVC 2014, equations 3 to 5. The filter is stored as its numerator and its power, which
are running means.
"""

from __future__ import annotations

import math
from functools import cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from motes import kernels
from motes.core.types import Singles, Spectra


@cache
def fast_length(least: int) -> int:
    """Return the least number from `least` on with no prime factors but 2, 3 and 5."""
    rest = least
    for factor in (2, 3, 5):
        while rest % factor == 0:
            rest //= factor
    return least if rest == 1 else fast_length(least + 1)


def rfft(lines: Singles) -> Spectra:
    """Return the transforms (N, n // 2 + 1) of lines (N, n)."""
    out = np.empty((len(lines), lines.shape[1] // 2 + 1), np.complex64)
    kernels.fourier.rfft(lines, out)
    return out


def rfft2(planes: Singles) -> Spectra:
    """Return the transforms (..., h, w // 2 + 1) of planes (..., h, w); h must be a fast length."""
    out = np.empty((*planes.shape[:-1], planes.shape[-1] // 2 + 1), np.complex64)
    kernels.fourier.rfft2(_volume(planes), _volume(out))
    return out


def irfft2(spectra: Spectra, columns: int) -> Singles:
    """Return the planes (..., h, columns) of transforms (..., h, up to columns // 2 + 1).

    Frequencies that are left out are 0.
    """
    out = np.empty((*spectra.shape[:-1], columns), np.float32)
    kernels.fourier.irfft2(_volume(spectra), _volume(out))
    return out


def _volume(array: Any) -> Any:
    return array.reshape(-1, *array.shape[-2:])


frequencies = cache(np.fft.fftfreq)
half_frequencies = cache(np.fft.rfftfreq)


@cache
def taper(rows: int, columns: int) -> Singles:
    """Return Hann's window (rows, columns); no value is 0."""
    down, across = (np.hanning(size + 2)[1:-1] for size in (rows, columns))
    return np.outer(down, across).astype(np.float32)


def gaussian(
    frequencies: NDArray[np.floating], sigma: float, shift: float = 0.0
) -> NDArray[np.complex128]:
    """Return the conjugate transform of a Gaussian label; its peak is 1 and lies at `shift`."""
    spread = np.pi * sigma * frequencies
    out: NDArray[np.complex128] = np.exp(2 * (1j * np.pi * shift * frequencies - spread**2))
    return math.sqrt(2 * np.pi) * sigma * out


def filtered(numerator: Spectra, power: Singles, spectra: Spectra) -> Spectra:
    """Return the spectrum of a filter's response to signals.

    Numerator and spectra are (K, ...), of the filter and of K signals, and `power` (...) is that of
    the filter, with the ridge added.
    """
    out = np.empty(power.shape, np.complex64)
    flat = len(numerator), -1
    kernels.fourier_ridge.correlate(
        numerator.reshape(flat), power.ravel(), spectra.reshape(flat), out.ravel()
    )
    return out


def updated(
    numerator: Spectra, power: Singles, spectra: Spectra, label: NDArray[np.complex128], rate: float
) -> tuple[Spectra, Singles]:
    """Return numerator and power moved by a share `rate` towards signals and their label (...)."""
    numerator, power, flat = numerator.copy(), power.copy(), (len(numerator), -1)
    kernels.fourier_ridge.teach(
        spectra.reshape(flat),
        label.ravel().astype(np.complex64),
        rate,
        numerator.reshape(flat),
        power.ravel(),
    )
    return numerator, power


def vertex(low: float, best: float, high: float) -> float:
    """Return how far the top of the parabola through three values is from the middle one."""
    curvature = float(low - 2 * best + high)
    return float(low - high) / (2 * curvature) if curvature < 0 else 0.0


def centered(plane: Singles) -> Singles:
    """Return a response (h, w) with its first value in the middle."""
    out = np.empty_like(plane)
    kernels.fourier_ridge.center(plane, out)
    return out
