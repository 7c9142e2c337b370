"""How models learn: each strategy against its equations, and all of them in the filter."""

import math
from collections.abc import Iterator
from itertools import cycle
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, strategies as st
from msgspec.structs import replace

from histogram_series import lessons, series
from kinds import CONFIGS, FILTER_KINDS
from motes import ParticleFilter, Status, Tracker, TrackerConfig, configure
from motes.core.types import Floats
from motes.cues.base import AdaptableCue
from motes.cues.color import Color
from motes.cues.gradients import Hog
from motes.sot.filtering.appearance_rule import AppearanceRule
from motes.sot.filtering.bin_updates import LEAST_NOISE, AnchoredKalman, GaussianBins, KalmanBins
from motes.sot.filtering.model_update import ExponentialForgetting, PerCue, UpdateResult
from oracles import region, scene


@given(st.integers(0, 99), st.floats(0, 1), st.floats(0, 1))
def test_forgetting_is_its_formula(seed: int, rate: float, anchor: float) -> None:
    first, *seen = series(seed, 9, 5)
    expected = first
    for each, learned in zip(
        seen,
        lessons(ExponentialForgetting(learning_rate=rate, anchor=anchor), first, seen),
        strict=True,
    ):
        expected = (1 - rate) * expected + rate * (anchor * first + (1 - anchor) * each)
        np.testing.assert_allclose(learned.histogram, expected, atol=1e-12)
        assert learned.histogram.sum() == pytest.approx(1)
        assert learned.memory is None


def walk(*indices: int) -> list[Any]:
    return [scene(index, (30.0 + index, 36)) for index in indices]


def small(**changes: Any) -> ParticleFilter:
    return ParticleFilter(
        particles=60,
        color=Color(space="hsv+v", bins=(8, 8, 8)),
        hog=Hog(),
        presence=AppearanceRule(margin=0.7, max_positions=500),
        **changes,
    )


BOTH = PerCue(cues={"color": KalmanBins(frames=2), "hog": GaussianBins()})


def started(config: TrackerConfig) -> Tracker:
    tracker = Tracker(config, 1)
    tracker.init(scene(0, (30.0, 36)), region((30.0, 36)))
    return tracker


@pytest.mark.parametrize(
    "strategy", [KalmanBins(frames=2), GaussianBins(), AnchoredKalman(frames=2), BOTH], ids=repr
)
def test_steps_learn_what_the_strategy_says(strategy: Any) -> None:
    config = small(adaptation=strategy)
    tracker = started(config)
    memories: dict[str, Any] = dict.fromkeys(config.cues)
    models = tracker.info.models
    for picture in walk(1, 2, 3, 4, 5):
        track = tracker.update(picture)
        assert tracker.info.models == models
        models = {}
        for name, cue in config.cues.items():
            before: Any = tracker.info.models[name]
            assert isinstance(cue, AdaptableCue)
            seen = cue.observe(before, picture, track.ellipse)
            each = config.strategies[name]
            learned = each.learn(memories[name], before.histogram, before.anchor, seen)
            memories[name] = learned.memory
            after: Any = tracker._state.models[name]
            np.testing.assert_array_equal(after.histogram, learned.histogram)
            models[name] = after


def test_nothing_is_learned_while_the_target_is_not_there() -> None:
    tracker = started(small(adaptation=BOTH))
    for picture in walk(1, 2, 3):
        tracker.update(picture)
    state: Any = tracker._state
    for index in range(4, 12):
        tracker.update(scene(index, None))
        after: Any = tracker._state
        assert after.models == state.models
        assert after.memories == state.memories
    assert tracker.info.track.status is Status.SEARCHING


def test_a_correction_teaches_nothing() -> None:
    tracker = started(small(adaptation=BOTH))
    for picture in walk(1, 2, 3):
        tracker.update(picture)
    state: Any = tracker._state
    for where in ((34.0, 36.0), (80.0, 20.0)):
        tracker.correct(region(where))
        after: Any = tracker._state
        assert after.models == state.models
        assert after.memories == state.memories


def test_where_nothing_is_seen_the_model_stays() -> None:
    """A flat picture has no gradients, whatever the rule says of its colors."""
    config = replace(
        small(adaptation=BOTH), presence=AppearanceRule(max_threshold=0.1, max_positions=500)
    )
    red = np.full((72, 96, 3), (200, 30, 40), np.uint8)
    tracker = started(config)
    before: Any = tracker._state
    tracker.update(red)
    after: Any = tracker._state
    assert list(after.memories) == ["color"]
    np.testing.assert_array_equal(after.models["hog"].histogram, before.models["hog"].histogram)


STRATEGIES = cycle(["forgetting", "kalman", "gaussian", "anchored_kalman"])


@pytest.mark.parametrize(("name", "kind"), [*zip(FILTER_KINDS, STRATEGIES, strict=False)])
def test_every_filter_takes_every_strategy(name: str, kind: str, tmp_path: Path) -> None:
    adaptation = {"type": kind} | ({"learning_rate": 0.1} if kind == "forgetting" else {})
    presence = {"max_positions": 100, "margin": 0, "deviations": 0}
    changes = {"particles": 40, "presence": presence, "adaptation": adaptation}
    config = configure(CONFIGS[name], changes)
    tracker = started(config)
    pictures = walk(*range(1, 16))
    for picture in pictures[:12]:
        tracker.update(picture)
    learned: Any = tracker._state
    for name in config.cues:
        model = learned.models[name]
        assert np.isfinite(model.histogram).all()
        assert model.histogram.min() >= 0
        assert model.histogram.sum() == pytest.approx(1)
        assert (model.histogram != model.anchor).any()
    tracker.save(tmp_path / "state")
    loaded = Tracker.load(tmp_path / "state")
    for picture in pictures[12:]:
        assert loaded.update(picture).ellipse == tracker.update(picture).ellipse


def tail(t: float, freedom: int) -> float:
    """Return the probability that Student's t exceeds t, by summing up its density."""
    x = np.linspace(0, abs(t), 20_001)
    scale = math.lgamma((freedom + 1) / 2) - math.lgamma(freedom / 2)
    scale -= 0.5 * math.log(freedom * math.pi)
    density = np.exp(scale - (freedom + 1) / 2 * np.log1p(x**2 / freedom))
    inner = float(np.trapezoid(density, x))
    return 0.5 - inner if t > 0 else 0.5 + inner


def equations_3_to_15(
    first: Floats, seen: list[Floats], frames: int, alpha: float
) -> Iterator[Floats]:
    """Yield the model, one bin and one equation at a time."""
    m = len(first)
    p, q, noise = list(first), [0.0] * m, math.nan
    residuals: list[list[float]] = []
    for o in seen:
        r = [o[b] - p[b] for b in range(m)]  # 8
        residuals.append(r)
        window = residuals[-frames:]
        spread = sum(x**2 for row in window for x in row) / (m * len(window))  # 9
        if len(residuals) < frames:
            yield np.array(p)
            continue
        if len(residuals) == frames:
            noise, drift, q = 0.5 * spread, 0.0, [0.5 * spread] * m  # 11
        else:
            drift = max(0.0, spread - noise - sum(q) / m)  # 10
        predicted = [q[b] + drift for b in range(m)]  # 4
        gain = [predicted[b] / (predicted[b] + noise) for b in range(m)]  # 5
        samples = [x**2 for x in r]
        mean = sum(samples) / m
        s = math.sqrt(sum((x - mean) ** 2 for x in samples) / (m - 1))
        t = (mean - spread) / (s / math.sqrt(m))  # 12
        refused = tail(t, m - 1) <= alpha  # 13 and 14
        if refused:
            q = predicted
        else:
            q = [(1 - gain[b]) * predicted[b] for b in range(m)]  # 7
            p = [p[b] + gain[b] * r[b] for b in range(m)]  # 6
        yield np.array(p)  # 15


@pytest.mark.slow
@given(st.integers(0, 9999), st.sampled_from([3, 8, 72]), st.sampled_from([1, 4, 10]))
def test_the_filter_is_its_equations(seed: int, bins: int, frames: int) -> None:
    first, *seen = series(seed, bins, 31)
    strategy = KalmanBins(frames=frames, alpha=0.1)
    expected = equations_3_to_15(first, seen, frames, 0.1)
    for learned, model in zip(lessons(strategy, first, seen), expected, strict=True):
        np.testing.assert_allclose(learned.histogram, model, atol=1e-9)
        assert learned.histogram.sum() == pytest.approx(1)


def equation_16(first: Floats, seen: list[Floats], beta: float, k: float) -> Iterator[Floats]:
    """Yield the model, one bin at a time."""
    for count in range(1, len(seen) + 1):
        model = []
        for b in range(len(first)):
            values = [first[b], *(each[b] for each in seen[:count])]
            mu = sum(values) / len(values)
            delta = math.sqrt(sum((value - mu) ** 2 for value in values) / len(values))
            if abs(values[-1] - mu) <= k * delta:
                model.append(beta * mu + (1 - beta) * values[-1])
            else:
                model.append(mu)
        yield np.array(model) / sum(model)


@given(
    st.integers(0, 9999),
    st.sampled_from([2, 8]),
    st.sampled_from([0.1, 0.9, 0.0]),
    st.sampled_from([3.0, 0.3]),
)
def test_the_gaussian_model_is_its_equation(seed: int, bins: int, beta: float, k: float) -> None:
    first, *seen = series(seed, bins, 16)
    strategy = GaussianBins(beta=beta, deviations=k)
    expected = equation_16(first, seen, beta, k)
    for learned, model in zip(lessons(strategy, first, seen), expected, strict=True):
        np.testing.assert_allclose(learned.histogram, model, atol=1e-9)


def anchored_kalman(first: Floats, seen: list[Floats], config: AnchoredKalman) -> Iterator[Floats]:
    """Yield the model, one bin at a time."""
    m = len(first)
    p, q, noise = list(first), 0.0, math.nan
    starts: list[float] = []
    for o in seen:
        if len(starts) < config.frames:
            rho = sum(math.sqrt(first[b] * o[b]) for b in range(m))
            starts.append(1 - rho)
            if len(starts) == config.frames:
                noise = max(LEAST_NOISE, sum(starts) / len(starts) / 2)
                q = noise
            yield np.array(p)
            continue
        p = [first[b] + config.persistence * (p[b] - first[b]) for b in range(m)]
        q = config.persistence**2 * q + config.change * noise
        rho = sum(math.sqrt(p[b] * o[b]) for b in range(m))
        if 1 - rho > config.deviations**2 * (q + noise):
            yield np.array(p)
            continue
        gain = q / (q + noise)
        p = [p[b] + gain * (o[b] - p[b]) for b in range(m)]
        q *= 1 - gain
        yield np.array(p)


@given(st.integers(0, 9999), st.sampled_from([3, 8, 72]), st.sampled_from([1, 4]))
def test_the_filter_around_the_first_frame_is_its_equations(
    seed: int, bins: int, frames: int
) -> None:
    first, *seen = series(seed, bins, 31)
    config = AnchoredKalman(frames=frames, persistence=0.9, change=0.1, deviations=1.5)
    expected = anchored_kalman(first, seen, config)
    for learned, model in zip(lessons(config, first, seen), expected, strict=True):
        np.testing.assert_allclose(learned.histogram, model, atol=1e-9)
        assert learned.histogram.sum() == pytest.approx(1)


def gains(sizes: list[float]) -> list[float]:
    """Return the shares of residuals of these sizes by which the model moves; 0 without any."""
    strategy, pattern = KalmanBins(frames=4), np.random.default_rng(0).normal(size=8)
    found, shares = UpdateResult(np.full(8, 1 / 8)), list[float]()
    for size in sizes:
        model, memory = found
        found = strategy.learn(memory, model, model, model + size * pattern)
        moved = float(np.linalg.norm(found.histogram - model))
        shares.append(moved / (float(np.linalg.norm(pattern)) * (size or 1.0)))
    return shares


def test_a_model_that_fits_without_any_residual() -> None:
    assert gains([0.0] * 8) == [0] * 8
    # There is no noise: what comes then is all change.
    assert gains([0.0] * 4 + [0.01] * 5)[-1] == pytest.approx(1)


def test_a_picture_without_noise_can_be_learned_from() -> None:
    first = np.full(8, 1 / 8)
    other = np.array([0.13, 0.12, *[1 / 8] * 6])
    *_, last = lessons(AnchoredKalman(), first, [first] * 12 + [other])
    assert (last.histogram != first).any()
