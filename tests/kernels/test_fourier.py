"""Transforms are those of `scipy.fft` to the last bit, of any number of lines and lanes."""

from __future__ import annotations

import numpy as np
import pytest
from scipy import fft

from motes import kernels
from motes.cues.fourier import irfft2, rfft, rfft2

RNG = np.random.default_rng(7)
FAST = [n for n in range(1, 130) if fft.next_fast_len(n, real=True) == n]


def test_planes_have_the_same_transforms() -> None:
    for n in FAST:
        for shape in ((2, n, 12), (3, 15, n), (n, n)):
            planes = RNG.normal(size=shape).astype(np.float32)
            spectra = rfft2(planes)
            np.testing.assert_array_equal(spectra, fft.rfft2(planes), err_msg=str(shape))
            back = irfft2(spectra, shape[-1])
            np.testing.assert_array_equal(back, fft.irfft2(spectra, shape[-2:]), err_msg=str(shape))


def test_lines_of_any_length_have_transforms() -> None:
    """All with small factors and all primes are the same; the others are so but for rounding."""
    for n in range(1, 34):
        lines = RNG.normal(size=(11, n)).astype(np.float32)
        spectra = rfft(lines)
        back = irfft2(spectra[:, None], n)[:, 0]
        same = n in FAST or all(n % factor for factor in range(2, n))
        off = 0.0 if same else 1e-5
        np.testing.assert_allclose(spectra, fft.rfft(lines), 0, off, err_msg=str(n))
        np.testing.assert_allclose(back, fft.irfft(spectra, n), 0, off, err_msg=str(n))


@pytest.mark.parametrize(("wide", "high"), [(4, 7), (1, 20), (30, 2), (99, 99)])
def test_a_filter_is_confined_to_a_box(wide: int, high: int) -> None:
    n, penalty = 20, np.float32(0.1)
    learned, multiplier = (rfft2(RNG.normal(size=(3, n, n)).astype(np.float32)) for _ in range(2))
    mask = np.zeros((n, n), np.float32)
    top, left = (max(n - size, 0) // 2 for size in (high, wide))
    mask[top : top + high, left : left + wide] = 1
    expected = fft.rfft2(fft.irfft2(penalty * learned + multiplier, (n, n)) * mask) / penalty
    moved, copied = multiplier.copy(), np.empty_like(learned)
    kernels.fourier_ridge.confine(learned, 0.1, wide, high, moved, copied)
    np.testing.assert_array_equal(copied, expected)
    np.testing.assert_array_equal(moved, multiplier + penalty * (learned - expected))


@pytest.mark.parametrize("rounds", [1, 2, 4])
def test_rounds_alternate_from_nothing(rounds: int) -> None:
    spectra, before, copied, multiplier = (
        rfft2(RNG.normal(size=(3, 16, 16)).astype(np.float32)) for _ in range(4)
    )
    label, expected, found = spectra[0].copy(), np.empty_like(spectra), np.empty_like(spectra)
    copied[:], multiplier[:] = 0, 0
    for left in reversed(range(rounds)):
        penalty = 1.0 if left == rounds - 1 else 0.1
        kernels.fourier_ridge.solve(
            spectra, label, before, copied, multiplier, penalty, 15.0, expected
        )
        if left:
            kernels.fourier_ridge.confine(expected, penalty, 5, 7, multiplier, copied)
    kernels.fourier_ridge.alternate(spectra, label, before, 15.0, (1.0, 0.1), rounds, 5, 7, found)
    np.testing.assert_array_equal(found, expected)


def test_ridge_regression_refuses_sizes_that_do_not_fit() -> None:
    """Memory beside an array is not touched, whatever a saved tracker holds."""
    spectra, power = np.ones((2, 6), np.complex64), np.ones(6, np.float32)
    plane, large = np.ones((2, 3), np.complex64), np.ones((4, 5), np.complex64)
    ridge = kernels.fourier_ridge
    for short in (spectra[:, :5].copy(), spectra[:1]):
        with pytest.raises(ValueError, match=r"^teach needs a filter \(K, F\)"):
            ridge.teach(spectra, spectra[0], 0.3, short, power)
        with pytest.raises(ValueError, match=r"^correlate needs a filter \(K, F\)"):
            ridge.correlate(short, power, spectra, spectra[0])
    with pytest.raises(ValueError, match=r"^pad needs two responses of one size"):
        ridge.pad(plane, large, 0.3, 4.0, large)
    with pytest.raises(ValueError, match=r"^center needs two planes of one size"):
        ridge.center(np.ones((2, 3), np.float32), np.ones((2, 2), np.float32))
