"""Ridge regression's two steps on spectra: what a filter answers, and how it learns."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from motes.kernels.compiling import unordered


@unordered
def correlate(
    numerator: NDArray[np.complex64],
    power: NDArray[np.float32],
    spectra: NDArray[np.complex64],
    out: NDArray[np.complex64],
) -> None:
    """Write what a filter (K, F) and (F,) makes of spectra (K, F): the response's spectrum (F,)."""
    for i in range(out.shape[0]):
        out[i] = 0.0
    for k in range(numerator.shape[0]):
        for i in range(out.shape[0]):
            learned, seen = numerator[k, i], spectra[k, i]
            real = learned.real * seen.real + learned.imag * seen.imag
            imaginary = learned.real * seen.imag - learned.imag * seen.real
            out[i] += complex(real, imaginary)
    for i in range(out.shape[0]):
        out[i] = complex(out[i].real / power[i], out[i].imag / power[i])


@unordered
def teach(
    spectra: NDArray[np.complex64],
    label: NDArray[np.complex64],
    rate: float,
    numerator: NDArray[np.complex64],
    power: NDArray[np.float32],
) -> None:
    """Put a share `rate` of a lesson, spectra (K, F) and label (F,), into a filter (K, F), (F,)."""
    new, kept = np.float32(rate), np.float32(1.0 - rate)
    for i in range(power.shape[0]):
        power[i] *= kept
    for k in range(numerator.shape[0]):
        for i in range(power.shape[0]):
            value = spectra[k, i]
            numerator[k, i] = kept * numerator[k, i] + new * label[i] * value
            power[i] += new * (value.real * value.real + value.imag * value.imag)
