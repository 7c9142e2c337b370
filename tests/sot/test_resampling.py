"""From distances to weights, the selection of particles, and how many there are."""

import math
from functools import cache
from typing import Any, cast

import numpy as np
import pytest
from hypothesis import example, given, strategies as st
from msgspec.structs import replace
from numpy.typing import NDArray

from motes import ConfigError, Ellipse, Frame, ParticleFilter, Status, Tracker, preset, synthetic
from motes.core.types import Floats
from motes.sot.filtering.appearance_rule import AppearanceRule
from motes.sot.filtering.likelihood import BestParticle, Exponential, Gaussian
from motes.sot.filtering.resampling import RESAMPLINGS, KldSampling, Multinomial, Weights

NAMES = RESAMPLINGS.names()
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
    runs, n = 1000, 7
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
@given(weights=shares, number=st.floats(0, 1, exclude_max=True))
@example(weights=[0, 0.1, 0.2, 0.7, 0, 0], number=0.0)
@example(weights=[0, 0.1, 0.2, 0.7, 0, 0], number=math.nextafter(1, 0))
@example(weights=[0, 1e-300, 0], number=0.5)
def test_any_random_number_chooses_a_particle_with_weight(
    name: str, weights: list[float], number: float
) -> None:
    w = np.array(weights) / sum(weights)
    drawn = draw(name, fixed(number), w, w.size)
    assert drawn.shape == w.shape
    assert (w[drawn] > 0).all()


@scheme
def test_tiny_weights_are_drawn_as_large_ones_are(name: str) -> None:
    weights = np.array([0.1, 0.0, 0.6, 0.3])
    for seed in range(20):
        np.testing.assert_array_equal(
            copies(name, weights, 40, seed), copies(name, weights * 2.0**-990, 40, seed)
        )


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


FIRST = Ellipse(50, 50, 10, 40)  # a mean half-axis of 20
WIDE = KldSampling(min=1, max=10**6, error=0.1, bin=1.0)


@cache
def clip() -> tuple[list[Frame], Ellipse]:
    """Return the frames of a clip, and its target's region."""
    frames, truths = zip(*synthetic.still((160, 120), target=(30, 40), frames=12), strict=True)
    return list(frames), truths[0][0].ellipse


def apart(k: int) -> Any:
    """Return ellipses in k bins, three in each."""
    ellipses = np.tile(np.array(FIRST), (3 * k, 1))
    ellipses[:, 0] = 20.0 * np.repeat(np.arange(k), 3) + 5
    return ellipses


@pytest.mark.parametrize(
    ("k", "quantile"), [(2, 6.635), (11, 23.209), (51, 76.154), (101, 135.807)]
)
def test_the_number_is_that_of_the_chi_square_test(k: int, quantile: float) -> None:
    """Fox's equation 7 stands for the 99 % quantile of k - 1 degrees of freedom over 2 epsilon."""
    expected = quantile / (2 * 0.1)
    assert WIDE.count(apart(k), FIRST) == pytest.approx(expected, rel=0.02, abs=1)


def test_bins_are_in_units_of_the_target() -> None:
    """Twice the target in twice the picture needs the same number; steps of e in size are bins."""
    ellipses = apart(9)
    twice = ellipses * [2, 2, 2, 2, 1]
    double = Ellipse(100, 100, 20, 80)
    assert WIDE.count(twice, double) == WIDE.count(ellipses, FIRST)
    assert WIDE.count(ellipses, double) < WIDE.count(ellipses, FIRST)
    sizes = np.tile(np.array(FIRST), (4, 1))
    sizes[:, 2:4] *= np.array([1, math.e, math.e**2, math.e**3])[:, None]
    assert WIDE.count(sizes, FIRST) == WIDE.count(apart(4), FIRST)


def numbers(config: ParticleFilter) -> list[int]:
    """Return how many particles each frame after the first had."""
    frames, target = clip()
    tracker = Tracker(config)
    tracker.init(frames[0], target)
    found = []
    for frame in frames[1:]:
        track = tracker.update(frame)
        info = tracker.info
        assert len(info.weights) == len(info.ellipses)
        assert info.weights.sum() == pytest.approx(1)
        assert track.effective_sample_size <= len(info.weights) + 1e-9
        found.append(len(info.weights))
    return found


def config(name: str = "nummiaro", **changes: Any) -> ParticleFilter:
    base = preset(name)
    assert isinstance(base, ParticleFilter)
    return replace(base, **changes)


@pytest.mark.parametrize("name", ["nummiaro", "maggio"])
def test_a_filter_with_a_budget_follows_its_spread(name: str) -> None:
    chosen = numbers(config(name, budget=KldSampling(min=20, max=300)))
    assert len(set(chosen)) > 3
    assert all(20 <= n <= 300 for n in chosen)
    assert numbers(config(name)) == [config(name).particles] * 11


def test_the_first_frame_is_within_the_budget() -> None:
    frames, target = clip()
    for least, most, first in ((300, 500, 300), (10, 40, 40), (50, 500, 100)):
        tracker = Tracker(config(budget=KldSampling(min=least, max=most)))
        tracker.init(frames[0], target)
        assert len(tracker.info.weights) == first


distances = st.lists(st.lists(st.floats(0, 1), min_size=5, max_size=5), min_size=1, max_size=2).map(
    np.array
)


@given(distances, st.floats(0.03, 2), st.floats(1e-6, 1) | st.just(0.0))
def test_equation_23(d: Floats, sigma: float, epsilon: float) -> None:
    """Without epsilon it is equation 22."""
    found = Gaussian(sigma=sigma, epsilon=epsilon).log(d)
    expected = np.log(np.exp(-(d**2) / (2 * sigma**2)) + epsilon)
    np.testing.assert_allclose(found, expected, rtol=1e-12, atol=1e-12)


def test_no_distance_is_too_large_for_a_small_sigma() -> None:
    """exp(-500000) is no number, its logarithm is; with epsilon, that is all that is left."""
    d = np.array([[0.0, 1.0]])
    assert Gaussian(sigma=1e-3).log(d)[0, 1] == pytest.approx(-500_000)
    for likelihood in (
        Gaussian(sigma=1e-3, epsilon=1e-300), BestParticle(floor=1e-3, epsilon=1e-300)
    ):  # fmt: skip
        assert likelihood.log(d)[0, 1] == pytest.approx(math.log(1e-300))


@given(distances, st.floats(1e-6, 1))
def test_equation_24(d: Floats, epsilon: float) -> None:
    likelihood = BestParticle(epsilon=epsilon, floor=0.02)
    found = likelihood.log(d)
    for row, log in zip(d, found, strict=True):
        # As it is printed, with log L = -1.
        sigma = max(math.sqrt(2) / 2 * math.sqrt(-(row.min() ** 2) / -1), 0.02)
        expected = Gaussian(sigma=sigma, epsilon=epsilon).log(row[None])[0]
        np.testing.assert_allclose(log, expected, rtol=1e-9, atol=1e-12)
        if row.min() > 0.03:
            assert log.max() == pytest.approx(math.log(math.exp(-1) + epsilon))


@given(distances, st.floats(0.1, 100))
def test_the_weight_of_zhao_and_pei(d: Floats, rate: float) -> None:
    """C exp(-lambda rho), rho being the distance: the nearest particle has the most."""
    found = Exponential(rate=rate).log(d)
    for row, log in zip(d, found, strict=True):
        weights = np.exp(-rate * row)
        np.testing.assert_allclose(Weights.from_log(log).values, weights / weights.sum())


def test_a_lost_target_gets_more_particles() -> None:
    rule = AppearanceRule(fraction=0.99, frames=1, margin=1.0, max_threshold=1.0)
    tracker = Tracker(config(budget=KldSampling(min=10, max=900), presence=rule))
    frames, target = clip()
    tracker.init(frames[0], target)
    numbers = []
    for frame in frames[1:]:
        assert tracker.update(frame).status is Status.SEARCHING
        numbers.append(len(tracker.info.weights))
    assert numbers[0] == 100
    assert min(numbers[2:]) > 150


def test_a_change_of_number_needs_a_selection() -> None:
    """Also with weights that are never unequal enough for one."""
    chosen = numbers(config(budget=KldSampling(), resampling=Multinomial(threshold=0.0)))
    assert len(set(chosen)) > 1


def test_a_range_upside_down() -> None:
    with pytest.raises(ConfigError, match="min is 60, and max is 50; make min smaller"):
        KldSampling(min=60, max=50)
