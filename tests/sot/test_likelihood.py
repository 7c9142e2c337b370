"""From distances to weights: Ng and Delp, equations 22 to 24, and the product of cues."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray

from motes.sot.filtering.likelihood import BestParticle, Exponential, Gaussian
from motes.sot.filtering.resampling import Weights

Floats = NDArray[np.float64]

NAMES = ["color", "edges"]
distances = st.lists(st.lists(st.floats(0, 1), min_size=5, max_size=5), min_size=1, max_size=2).map(
    np.array
)


@given(distances, st.floats(0.03, 2), st.floats(1e-6, 1) | st.just(0.0))
def test_equation_23(d: Floats, sigma: float, epsilon: float) -> None:
    """Without epsilon it is equation 22."""
    found = Gaussian(sigma=sigma, epsilon=epsilon).log(NAMES[: len(d)], d)
    expected = np.log(np.exp(-(d**2) / (2 * sigma**2)) + epsilon)
    np.testing.assert_allclose(found, expected, rtol=1e-12, atol=1e-12)


def test_no_distance_is_too_large_for_a_small_sigma() -> None:
    """exp(-500000) is no number, its logarithm is; with epsilon, that is all that is left."""
    d = np.array([[0.0, 1.0]])
    assert Gaussian(sigma=1e-3).log(["color"], d)[0, 1] == pytest.approx(-500_000)
    for likelihood in (
        Gaussian(sigma=1e-3, epsilon=1e-300), BestParticle(floor=1e-3, epsilon=1e-300)
    ):  # fmt: skip
        assert likelihood.log(["color"], d)[0, 1] == pytest.approx(math.log(1e-300))


@given(distances, st.floats(1e-6, 1))
def test_equation_24(d: Floats, epsilon: float) -> None:
    likelihood = BestParticle(epsilon=epsilon, floor=0.02)
    found = likelihood.log(NAMES[: len(d)], d)
    for row, log in zip(d, found, strict=True):
        # As it is printed, with log L = -1.
        sigma = max(math.sqrt(2) / 2 * math.sqrt(-(row.min() ** 2) / -1), 0.02)
        expected = Gaussian(sigma=sigma, epsilon=epsilon).log(["color"], row[None])[0]
        np.testing.assert_allclose(log, expected, rtol=1e-9, atol=1e-12)
        if row.min() > 0.03:
            assert log.max() == pytest.approx(math.log(math.exp(-1) + epsilon))


@given(distances, st.floats(0.1, 100))
def test_the_weight_of_zhao_and_pei(d: Floats, rate: float) -> None:
    """C exp(-lambda rho), rho being the distance: the nearest particle has the most."""
    found = Exponential(rate=rate).log(NAMES[: len(d)], d)
    for row, log in zip(d, found, strict=True):
        weights = np.exp(-rate * row)
        np.testing.assert_allclose(Weights.from_log(log).values, weights / weights.sum())
