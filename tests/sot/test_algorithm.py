"""The protocol of algorithms: what each of them keeps and reports."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from motes.sot.algorithm import Algorithm
from motes.sot.presets import configure, preset
from motes.sot.tracker import Tracker
from oracles import region, scene

NAMES = ("default", "nummiaro", "maggio", "mean_shift")


def algorithm(name: str) -> Algorithm[Any]:
    return configure(
        preset(name), {"presence": {"max_positions": 100}} if name != "default" else {}
    )


def started(name: str, seed: int = 0) -> Tracker:
    tracker = Tracker(preset(name), seed)
    tracker.init(scene(0, (30.0, 36)), region((30.0, 36)))
    return tracker


@pytest.mark.parametrize("name", NAMES)
def test_an_algorithm_keeps_the_state_that_it_names(name: str) -> None:
    each, rng = algorithm(name), np.random.default_rng(0)
    first, last = scene(0, (30.0, 36)), scene(1, (32.0, 36))
    state, info = each.init(rng, first, region((30.0, 36)))
    assert type(state) is each.state_type
    for after, report in (
        each.step(rng, state, last),
        each.correct(state, first, region((32.0, 36))),
    ):
        assert type(after) is each.state_type
        assert type(report) is type(info)
        each.typed(after, first if report.track.frame == 0 else last)


@pytest.mark.parametrize("name", NAMES)
def test_a_step_changes_nothing_that_it_is_given(name: str) -> None:
    each, picture = algorithm(name), scene(1, (32.0, 36))
    state, _ = each.init(np.random.default_rng(0), scene(0, (30.0, 36)), region((30.0, 36)))
    one, other = (each.step(np.random.default_rng(1), state, picture)[1] for _ in "12")
    assert one.track.ellipse == other.track.ellipse
    np.testing.assert_array_equal(one.ellipses, other.ellipses)


def test_the_default_tracker_reports_no_particles_that_it_does_not_have() -> None:
    tracker = started("default")
    assert tracker.info.ellipses.shape == (0, 5)
    assert tracker.info.weights.shape == (0,)
    tracker.update(scene(1, (32.0, 36)))
    particles = tracker.info.ellipses
    assert len(np.unique(particles[:, :2], axis=0)) == len(particles) >= 100
    assert tracker.info.weights.sum() == pytest.approx(1)
    tracker.correct(region((32.0, 36)))
    assert not len(tracker.info.ellipses)
