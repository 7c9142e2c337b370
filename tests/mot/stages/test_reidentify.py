"""Occluded objects that reappear."""

from __future__ import annotations

import numpy as np
import pytest
from msgspec.structs import replace

from motes.core.detection import Detection
from motes.core.geometry import Box
from motes.core.track import Status
from motes.mot.stages.reidentify import reidentify
from motes.mot.tracked_object import TrackedObject
from scene_objects import BLUE, DT, RED, config, occluded, picture, visible

PLACE = Box(40, 30, 20, 40)
BEFORE = picture(0, (PLACE, RED))


def test_an_object_is_visible_again_where_it_is_detected() -> None:
    near, far = PLACE._replace(x=50), PLACE._replace(x=150)
    frame = picture(5, (near, RED), (far, RED))
    found = [Detection(far), Detection(near)]
    (after,), free = reidentify([occluded(1, BEFORE, PLACE)], found, frame, DT, config())
    assert after.track.box == pytest.approx(near)
    assert (after.track.status, after.detected, after.last_time) == (
        Status.TRACKING, True, frame.time,
    )  # fmt: skip
    assert after.track.confidence > 0.5
    assert free == [found[0]]


@pytest.mark.parametrize(("surprise", "reached"), [(0.005, False), (0.05, True)])
def test_the_gate_grows_with_time_the_faster_the_less_evenly_an_object_moved(
    surprise: float, reached: bool
) -> None:
    away = PLACE._replace(x=78)  # more than two mean half-axes
    hidden = replace(occluded(1, BEFORE, PLACE), surprise=(surprise, surprise))
    for index, found in ((2, False), (15, reached)):
        frame = picture(index, (away, RED))
        _, free = reidentify([hidden], [Detection(away)], frame, DT, config())
        assert (not free) == found


def test_the_variance_of_a_forecast_is_that_of_simulated_ones() -> None:
    """Of paths whose velocity follows each error by the share that it follows a detection by."""
    rng, frames, kept = np.random.default_rng(0), 12, 0.8
    errors = rng.normal(0, 3, (20_000, frames))
    velocity = np.cumsum((1 - kept) * errors, axis=1) - (1 - kept) * errors
    ends = (velocity + errors).sum(axis=1)
    one = replace(occluded(1, BEFORE, PLACE), surprise=(9.0, 9.0))
    variance = one.variance(one.last_time + frames * DT, DT, kept)
    assert variance == pytest.approx([ends.var()] * 2, rel=0.05)


def test_surprise_is_how_far_detections_are_off() -> None:
    def follow(one: TrackedObject, x: float) -> TrackedObject:
        return one.predict(DT).detect(PLACE._replace(x=x), 0).update_velocity(0.8, DT)

    even = uneven = visible(1, BEFORE, PLACE)
    for n in range(1, 40):
        even, uneven = follow(even, 40 + 2 * n), follow(uneven, 40 + 2 * n + 4 * (-1) ** n)
    assert max(even.surprise) < 0.01 < uneven.surprise[0]
    assert uneven.surprise[1] < 0.01


def test_an_object_may_reappear_beside_its_occluder() -> None:
    """The occluder has carried it away, much farther than its own gate reaches."""
    away = PLACE._replace(x=150)
    frame = picture(2, (away, RED))
    occluder = visible(2, frame, away)
    for by, found in ((None, False), (2, True)):
        objects = [occluded(1, BEFORE, PLACE, by), occluder]
        _, free = reidentify(objects, [Detection(away)], frame, DT, config())
        assert (not free) == found


def test_a_detection_of_another_color_is_no_object_that_was_there() -> None:
    away = PLACE._replace(x=60)
    for color, found in ((RED, True), (BLUE, False)):
        frame = picture(2, (away, color))
        _, free = reidentify([occluded(1, BEFORE, PLACE)], [Detection(away)], frame, DT, config())
        assert (not free) == found


def test_visible_objects_get_none() -> None:
    objects, found = [visible(1, BEFORE, PLACE)], [Detection(PLACE)]
    assert reidentify(objects, found, picture(1), DT, config()) == (objects, found)
