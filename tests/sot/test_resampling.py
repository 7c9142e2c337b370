"""Weights and the selection of particles."""

from __future__ import annotations

import math
from typing import Any, cast

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray

from motes.sot.filtering.resampling import RESAMPLINGS, Multinomial, Weights

Floats = NDArray[np.float64]
NAMES = RESAMPLINGS.known()
scheme = pytest.mark.parametrize("name", NAMES)

shares = st.lists(st.floats(0, 1), min_size=1, max_size=40).filter(lambda w: sum(w) > 1e-3)


class Fixed:
    """A random generator that only ever returns one number."""

    def __init__(self, number: float) -> None:
        self.number = number

    def random(self, n: int | None = None) -> Any:
        """Return the number, or n of them."""
        return self.number if n is None else np.full(n, self.number)


def fixed(number: float) -> np.random.Generator:
    return cast(np.random.Generator, Fixed(number))


def draw(name: str, rng: np.random.Generator, weights: Floats, n: int) -> NDArray[np.intp]:
    """Return n ancestors by the method of a name; weights need not sum to 1."""
    return RESAMPLINGS.resolve(name)().ancestors(rng, Weights(weights, weights, False), n)


def copies(name: str, weights: Floats, n: int, seed: int) -> NDArray[np.intp]:
    drawn = draw(name, np.random.default_rng(seed), weights, n)
    assert drawn.shape == (n,)
    return np.bincount(drawn, minlength=weights.size)


@scheme
def test_expected_copies_are_n_times_the_weight(name: str) -> None:
    weights = np.array([0.0, 0.31, 0.02, 0.17, 0.0, 0.5])
    runs, n = 4000, 7
    rng = np.random.default_rng(5)
    total = np.zeros((runs, weights.size))
    for run in range(runs):
        total[run] = np.bincount(draw(name, rng, weights, n), minlength=weights.size)
    error = total.std(axis=0) / math.sqrt(runs)
    assert (np.abs(total.mean(axis=0) - n * weights) <= 4 * error + 1e-12).all()


@given(shares, st.integers(0, 1000))
def test_systematic_copies_are_within_one_of_the_expected(weights: list[float], seed: int) -> None:
    w = np.array(weights) / sum(weights)
    assert (np.abs(copies("systematic", w, w.size, seed) - w.size * w) < 1 + 1e-9).all()


@scheme
@pytest.mark.parametrize("number", [0.0, 0.5, math.nextafter(1, 0)])
def test_a_particle_without_weight_is_never_chosen(name: str, number: float) -> None:
    for weights in ([0, 0, 0.4, 0, 0.6, 0], [0, 1, 0], [0, 0.1, 0.2, 0.7, 0, 0], [0, 1e-300, 0]):
        w = np.array(weights, float)
        assert (w[draw(name, fixed(number), w, w.size)] > 0).all()


@scheme
@given(weights=shares, number=st.floats(0, 1, exclude_max=True))
def test_any_random_number_chooses_a_particle_with_weight(
    name: str, weights: list[float], number: float
) -> None:
    w = np.array(weights) / sum(weights)
    drawn = draw(name, fixed(number), w, w.size)
    assert drawn.shape == w.shape
    assert (w[drawn] > 0).all()


@given(st.lists(st.floats(-700, 700), min_size=1, max_size=30))
def test_normalization(log: list[float]) -> None:
    weights = Weights.from_log(np.array(log))
    exact = np.exp(np.array(log, np.longdouble) - max(log))
    np.testing.assert_allclose(weights.values, (exact / exact.sum()).astype(float), 1e-12, 1e-300)
    assert not weights.degenerate
    assert 1 - 1e-9 <= weights.effective_sample_size <= len(log) * (1 + 1e-9)


def test_weights_that_are_none_are_repaired() -> None:
    given = np.array([0.0, np.nan, -np.inf, np.inf, math.log(3)])
    weights = Weights.from_log(given)
    np.testing.assert_allclose(weights.values, [0.25, 0, 0, 0, 0.75])
    np.testing.assert_array_equal(weights.log, [0, -np.inf, -np.inf, -np.inf, math.log(3)])
    assert not weights.degenerate
    assert np.isnan(given[1])  # what is given stays
    for bad in (np.nan, np.inf, -np.inf):
        uniform = Weights.from_log(np.full(4, bad))
        np.testing.assert_array_equal(uniform.values, [0.25] * 4)
        assert uniform.degenerate
        assert np.isfinite(uniform.log).all()


@pytest.mark.parametrize(
    ("values", "size", "thresholds"),
    [
        ([0.25] * 4, 4, {1.0}),
        ([0.5, 0.5, 0, 0], 2, {1.0, 0.75}),
        ([1, 0, 0, 0], 1, {1.0, 0.75, 0.5}),
    ],
)
def test_selection_is_due_where_few_weights_count(
    values: list[float], size: float, thresholds: set[float]
) -> None:
    with np.errstate(divide="ignore"):
        weights = Weights.from_log(np.log(values))
    assert weights.effective_sample_size == pytest.approx(size)
    asked = (1.0, 0.75, 0.5, 0.0)
    assert {t for t in asked if Multinomial(threshold=t).due(weights)} == thresholds
