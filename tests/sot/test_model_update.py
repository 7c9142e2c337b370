"""How models learn: each strategy against its equations, and all of them in the filter."""

from __future__ import annotations

from itertools import cycle
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from msgspec.structs import replace

from histogram_series import lessons, series
from kinds import CONFIGS, FILTER_KINDS
from motes.cues.base import AdaptableCue
from motes.cues.color import Color
from motes.cues.gradients import Hog
from motes.sot.filtering.appearance_rule import AppearanceRule
from motes.sot.filtering.bin_updates import AnchoredKalman, GaussianBins, KalmanBins
from motes.sot.filtering.model_update import ExponentialForgetting, PerCue
from motes.sot.particle_filter import ParticleFilter
from motes.sot.presets import TrackerConfig, configure
from motes.sot.tracker import Tracker
from oracles import region, scene

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


# In the filter


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


STRATEGIES = ["forgetting", "kalman", "gaussian", "anchored_kalman"]


@pytest.mark.parametrize(("name", "kind"), [*zip(FILTER_KINDS, cycle(STRATEGIES), strict=False)])
def test_every_filter_takes_every_strategy(name: str, kind: str, tmp_path: Path) -> None:
    config = configure(
        CONFIGS[name],
        {
            "particles": 40,
            "presence": {"max_positions": 100, "margin": 0, "deviations": 0},
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
