"""Fourier transforms of real signals in single precision.

`scipy.fft` has the same results, and takes a third of a second to import.
"""

from __future__ import annotations

from functools import cache
from typing import Any

import numpy as np

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
