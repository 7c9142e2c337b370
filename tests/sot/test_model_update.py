"""How models learn: each strategy against its equations, and all of them in the filter."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from msgspec.structs import replace
from numpy.typing import NDArray

from kinds import FILTER_KINDS
from motes.core.config import from_flag, from_toml, to_toml
from motes.core.errors import ConfigError
from motes.core.track import Status
from motes.cues.base import AdaptableCue
from motes.cues.color import Color
from motes.cues.hog import Hog
from motes.sot.filtering.appearance_rule import AppearanceRule
from motes.sot.filtering.model_update import (
    ExponentialForgetting,
    GaussianBins,
    KalmanBins,
    KalmanMemory,
    PerCue,
    Strategy,
    UpdateDiagnostics,
    UpdateResult,
    critical,
)
from motes.sot.particle_filter import ParticleFilter
from motes.sot.particle_state import FilterInfo
from motes.sot.presets import PRESETS, TrackerConfig, configure, preset
from motes.sot.tracker import Tracker
from oracles import region, scene

Floats = NDArray[np.float64]


def histogram(rng: np.random.Generator, bins: int) -> Floats:
    return rng.dirichlet(np.full(bins, 0.5))


def series(seed: int, bins: int, frames: int) -> list[Floats]:
    """Return a target's histograms: noise around one that changes, at times by a leap."""
    rng = np.random.default_rng(seed)
    true, out = histogram(rng, bins), []
    for _ in range(frames):
        true = 0.97 * true + 0.03 * histogram(rng, bins)
        share = rng.choice([0.02, 0.1, 0.9], p=[0.6, 0.3, 0.1])
        out.append((1 - share) * true + share * histogram(rng, bins))
    return out


def lessons(strategy: Strategy, first: Floats, seen: list[Floats]) -> Iterator[UpdateResult]:
    model, memory = first, None
    for each in seen:
        learned = strategy.learn(memory, model, first, each)
        yield learned
        model, memory = learned.histogram, learned.memory


# Forgetting


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
        assert learned.diagnostics is None


@pytest.mark.parametrize("anchor", [0.0, 0.4, 1.0])
def test_in_the_long_run_the_anchor_keeps_its_share(anchor: float) -> None:
    first, seen = series(0, 9, 2)
    *_, last = lessons(ExponentialForgetting(learning_rate=0.1, anchor=anchor), first, [seen] * 400)
    np.testing.assert_allclose(last.histogram, anchor * first + (1 - anchor) * seen, atol=1e-9)


# The Kalman filter


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
) -> Iterator[tuple[Floats, float, bool]]:
    """Yield model, gain and whether the frame was refused, one bin and one equation at a time."""
    m = len(first)
    p, q, noise = list(first), [0.0] * m, math.nan
    residuals: list[list[float]] = []
    for o in seen:
        r = [o[b] - p[b] for b in range(m)]  # 8
        residuals.append(r)
        window = residuals[-frames:]
        spread = sum(x**2 for row in window for x in row) / (m * len(window))  # 9
        if len(residuals) < frames:
            yield np.array(p), 0.0, False
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
        yield np.array(p), 0.0 if refused else gain[0], refused  # 15


@given(st.integers(0, 9999), st.sampled_from([3, 8, 72]), st.sampled_from([1, 4, 10]))
@settings(max_examples=40, deadline=None)
def test_the_filter_is_its_equations(seed: int, bins: int, frames: int) -> None:
    first, *seen = series(seed, bins, 31)
    strategy = KalmanBins(frames=frames, alpha=0.1)
    expected = equations_3_to_15(first, seen, frames, 0.1)
    model = first
    for each, learned, (histogram, gain, refused) in zip(
        seen, lessons(strategy, first, seen), expected, strict=True
    ):
        assert learned.diagnostics is not None
        np.testing.assert_allclose(learned.histogram, histogram, atol=1e-9)
        np.testing.assert_allclose(learned.diagnostics.residuals, each - model, atol=1e-9)
        assert learned.diagnostics.gain == pytest.approx(gain)
        assert learned.diagnostics.accepted == (not refused)
        assert learned.histogram.sum() == pytest.approx(1)
        model = learned.histogram


def test_series_have_frames_of_both_kinds() -> None:
    """Else the test before this one would say little."""
    first, *seen = series(1, 72, 60)
    found = [
        learned.diagnostics.accepted
        for learned in lessons(KalmanBins(), first, seen)
        if learned.diagnostics
    ]
    assert 3 <= found.count(0.0) <= 12


def given_residuals(bins: int, sizes: list[float]) -> list[UpdateResult]:
    """Return what becomes of a model that finds the same residuals, of these sizes, every time."""
    strategy, model, memory = KalmanBins(frames=4), np.full(bins, 1 / bins), None
    pattern = np.random.default_rng(0).normal(size=bins)
    found = []
    for size in sizes:
        found.append(strategy.learn(memory, model, model, model + size * pattern))
        model, memory = found[-1].histogram, found[-1].memory
    return found


def gains(sizes: list[float]) -> list[float]:
    return [
        learned.diagnostics.gain for learned in given_residuals(8, sizes) if learned.diagnostics
    ]


def test_gains_worked_by_hand() -> None:
    """Half of the residuals is noise, and half is learned, as long as they stay as they are."""
    assert gains([0.01] * 10) == pytest.approx([0, 0, 0] + [1 / 2] * 7)


def test_what_would_be_a_variance_below_zero_is_none() -> None:
    """Equation 10, where residuals have become smaller: then the gain only falls, as 1 / n."""
    found = gains([0.01] * 4 + [1e-6] * 8)
    assert found[3] == pytest.approx(1 / 2)
    # As long as the large ones are among the last four, there is drift.
    assert [1 / b - 1 / a for a, b in pairwise(found[7:])] == pytest.approx([1.0] * 4)


def test_a_model_that_fits_without_any_residual() -> None:
    assert gains([0.0] * 8) == [0] * 8
    # There is no noise: what comes then is all change.
    assert gains([0.0] * 4 + [0.01] * 5)[-1] == pytest.approx(1)


def test_a_leap_is_refused_and_then_believed() -> None:
    found = given_residuals(72, [0.01] * 8 + [0.05] * 6)
    accepted = [learned.diagnostics.accepted for learned in found if learned.diagnostics]
    assert accepted[:8] == [1] * 8
    assert accepted[8] == 0
    assert accepted[-1] == 1
    refused = found[8]
    np.testing.assert_array_equal(refused.histogram, found[7].histogram)
    before, after = found[7].memory, refused.memory
    assert isinstance(before, KalmanMemory)
    assert isinstance(after, KalmanMemory)
    assert after.variance > before.variance  # nothing was measured, and time has passed


def test_significance_is_the_chance_to_refuse_a_frame_like_any_other() -> None:
    rng = np.random.default_rng(0)
    first = np.full(400, 1 / 400)
    for alpha in (0.02, 0.1, 0.4):
        refused = 0
        for _ in range(400):
            seen = [first + rng.normal(0, 1e-4, 400) for _ in range(30)]
            strategy = KalmanBins(frames=30, alpha=alpha)
            *_, last = lessons(strategy, first, seen)
            assert last.diagnostics is not None
            refused += last.diagnostics.accepted == 0
        assert refused / 400 == pytest.approx(alpha, abs=3 * math.sqrt(alpha / 400) + 0.02)


@pytest.mark.parametrize(
    ("alpha", "freedom", "value"),
    [
        (0.1, 1, 3.078), (0.1, 2, 1.886), (0.1, 7, 1.415), (0.1, 71, 1.294), (0.1, 100_000, 1.282),
        (0.05, 7, 1.895), (0.05, 30, 1.697), (0.025, 10, 2.228), (0.01, 3, 4.541), (0.01, 7, 2.998),
        (0.5, 7, 0.0),
    ],
)  # fmt: skip
def test_critical_values(alpha: float, freedom: int, value: float) -> None:
    """As printed in tables."""
    assert critical(alpha, freedom) == pytest.approx(value, abs=6e-4)
    if 1 < freedom < 1000:
        assert tail(critical(alpha, freedom), freedom) == pytest.approx(alpha, rel=1e-5)


# The Gaussian model


def equation_16(
    first: Floats, seen: list[Floats], beta: float, k: float
) -> Iterator[tuple[Floats, float]]:
    """Yield the model and the share of bins near their mean, one bin at a time."""
    model = list(first)
    for count in range(1, len(seen) + 1):
        near = 0
        for b in range(len(model)):
            values = [first[b], *(each[b] for each in seen[:count])]
            mu = sum(values) / len(values)
            delta = math.sqrt(sum((value - mu) ** 2 for value in values) / len(values))
            if abs(model[b] - mu) <= k * delta:
                near += 1
                model[b] = beta * mu + (1 - beta) * model[b]
            else:
                model[b] = mu
        total = sum(model)
        model = [value / total for value in model]
        yield np.array(model), near / len(model)


@given(
    st.integers(0, 9999),
    st.sampled_from([2, 8]),
    st.sampled_from([0.1, 0.9, 0.0]),
    st.sampled_from([3.0, 0.3]),
)
@settings(max_examples=40)
def test_the_gaussian_model_is_its_equation(seed: int, bins: int, beta: float, k: float) -> None:
    first, *seen = series(seed, bins, 16)
    strategy = GaussianBins(beta=beta, deviations=k)
    model = first
    for each, learned, (histogram, near) in zip(
        seen, lessons(strategy, first, seen), equation_16(first, seen, beta, k), strict=True
    ):
        assert learned.diagnostics is not None
        np.testing.assert_allclose(learned.histogram, histogram, atol=1e-9)
        np.testing.assert_allclose(learned.diagnostics.residuals, each - model, atol=1e-9)
        assert learned.diagnostics.gain == beta
        assert learned.diagnostics.accepted == pytest.approx(near)
        model = learned.histogram


def test_a_bin_far_from_what_is_seen_becomes_its_mean() -> None:
    """Also a lasting change is believed, as soon as what was before is an exception."""
    first, later = np.array([0.9, 0.1]), np.array([0.2, 0.8])
    found = list(lessons(GaussianBins(beta=0, deviations=2.9), first, [later] * 12))
    near = [learned.diagnostics.accepted for learned in found if learned.diagnostics]
    # After n such frames, the first one is sqrt(n) delta away from the mean.
    assert near == [1] * 8 + [0] + [1] * 3
    np.testing.assert_allclose(found[7].histogram, first)
    np.testing.assert_allclose(found[8].histogram, (first + 9 * later) / 10)


# In the filter


def walk(*indices: int) -> list[Any]:
    return [scene(index, (30.0 + index, 36)) for index in indices]


def small(**changes: Any) -> ParticleFilter:
    return ParticleFilter(
        particles=60,
        color=Color(space="hsv+v", bins=(8, 8, 8)),
        hog=Hog(),
        presence=AppearanceRule(margin=0.7, stride=4),
        **changes,
    )


BOTH = PerCue(cues={"color": KalmanBins(frames=2), "hog": GaussianBins()})


def diagnostics(tracker: Tracker) -> Mapping[str, UpdateDiagnostics]:
    assert isinstance(tracker.info, FilterInfo)
    return tracker.info.update_diagnostics


def started(config: TrackerConfig) -> Tracker:
    tracker = Tracker(config, 1)
    tracker.init(scene(0, (30.0, 36)), region((30.0, 36)))
    return tracker


@pytest.mark.parametrize("strategy", [KalmanBins(frames=2), GaussianBins(), BOTH], ids=repr)
def test_steps_learn_what_the_strategy_says(strategy: Any) -> None:
    config = small(adaptation=strategy)
    tracker = started(config)
    assert diagnostics(tracker) == {}  # the first frame is the model
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
            lesson = diagnostics(tracker)[name]
            assert learned.diagnostics is not None
            np.testing.assert_array_equal(lesson.residuals, learned.diagnostics.residuals)
            assert lesson[1:] == learned.diagnostics[1:]
            memories[name] = learned.memory
            after: Any = tracker._state.models[name]
            np.testing.assert_array_equal(after.histogram, learned.histogram)
            assert (after.histogram != before.histogram).any() == (lesson.gain > 0)
            models[name] = after


def test_each_cue_has_its_own_strategy() -> None:
    config = small(adaptation=PerCue(cues={"hog": GaussianBins()}))
    assert config.strategies == {"color": ExponentialForgetting(), "hog": GaussianBins()}
    assert small(adaptation=KalmanBins()).strategies == dict.fromkeys(
        ["color", "hog"], KalmanBins()
    )
    tracker = started(config)
    for picture in walk(1, 2, 3):
        tracker.update(picture)
        assert list(diagnostics(tracker)) == ["hog"]
    with pytest.raises(ConfigError, match=r"adaptation\.cues names 'edges'; the cues in use are"):
        small(adaptation=PerCue(cues={"edges": GaussianBins()}))


def test_nothing_is_learned_while_the_target_is_not_there() -> None:
    tracker = started(small(adaptation=BOTH))
    for picture in walk(1, 2, 3):
        tracker.update(picture)
    state: Any = tracker._state
    for index in range(4, 12):
        tracker.update(scene(index, None))
        assert diagnostics(tracker) == {}
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
    config = replace(small(adaptation=BOTH), presence=AppearanceRule(max_threshold=0.1, stride=4))
    red = np.full((72, 96, 3), (200, 30, 40), np.uint8)
    tracker = started(config)
    before: Any = tracker._state
    tracker.update(red)
    after: Any = tracker._state
    assert list(diagnostics(tracker)) == ["color"]
    assert list(after.memories) == ["color"]
    np.testing.assert_array_equal(after.models["hog"].histogram, before.models["hog"].histogram)


@pytest.mark.parametrize("name", FILTER_KINDS)
@pytest.mark.parametrize("kind", ["forgetting", "kalman", "gaussian"])
def test_every_filter_takes_every_strategy(name: str, kind: str, tmp_path: Path) -> None:
    config = configure(
        PRESETS[name],
        {
            "particles": 40,
            "presence": {"stride": 8, "margin": 0, "deviations": 0},
            "adaptation": {
                "type": kind,
                **({"learning_rate": 0.1} if kind == "forgetting" else {}),
            },
        },
    )
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
    again: Any = loaded._state
    learned = tracker._state
    for name in config.cues:
        np.testing.assert_array_equal(again.models[name].histogram, learned.models[name].histogram)
    assert list(again.memories) == list(learned.memories)


# Configurations


def test_keys_of_the_first_strategy_need_no_type() -> None:
    """As they did when there was no other."""
    for name in ("nummiaro", "nummiaro:adaptive", "maggio", "ng_delp"):
        for change in (
            from_flag("adaptation.learning_rate", "0.2"),
            from_toml("[adaptation]\nlearning_rate = 0.2", "text"),
        ):
            config = configure(preset(name), change)
            base: Any = preset(name)
            assert isinstance(config, ParticleFilter)
            anchor = base.adaptation.anchor
            assert config.adaptation == ExponentialForgetting(learning_rate=0.2, anchor=anchor)


def test_strategies_from_flags() -> None:
    kalman = configure(
        preset("nummiaro"),
        from_flag("adaptation.type", "kalman"),
        from_flag("adaptation.frames", "5"),
    )
    assert isinstance(kalman, ParticleFilter)
    assert kalman.adaptation == KalmanBins(frames=5)
    zhao = configure(preset("zhao_pei"), from_flag("adaptation.cues.color.alpha", "0.05"))
    assert isinstance(zhao, ParticleFilter)
    expected: dict[str, Strategy] = {"color": KalmanBins(alpha=0.05), "hog": GaussianBins()}
    assert zhao.adaptation == PerCue(cues=expected)
    still = configure(preset("zhao_pei"), from_flag("adaptation.type", "forgetting"))
    assert isinstance(still, ParticleFilter)
    assert still.adaptation == ExponentialForgetting()
    assert configure(preset("nummiaro"), from_toml(to_toml(zhao), "text")) == zhao


@pytest.mark.parametrize(
    ("kind", "field", "values"),
    [
        (ExponentialForgetting, "learning_rate", [-0.1, 1.1]),
        (KalmanBins, "frames", [0, 1.5]),
        (KalmanBins, "alpha", [0, 0.6, math.nan]),
        (GaussianBins, "beta", [-0.1, 1.1]),
        (GaussianBins, "deviations", [-1, math.inf]),
        (PerCue, "cues", [{"color": "kalman"}, {"color": PerCue()}]),
    ],
)
def test_settings_that_are_refused(kind: Any, field: str, values: list[Any]) -> None:
    for value in values:
        with pytest.raises(ConfigError, match=f"^{field}"):
            kind(**{field: value})
