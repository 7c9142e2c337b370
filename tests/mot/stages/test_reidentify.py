"""Occluded objects that reappear."""

from __future__ import annotations

import pytest

from motes.core.detection import Detection
from motes.core.geometry import Box
from motes.core.track import Status
from motes.mot.detection_outcome import DetectionOutcome
from motes.mot.stages.reidentify import reidentify
from scene_objects import BLUE, RED, config, occluded, picture, visible

PLACE = Box(40, 30, 20, 40)
BEFORE = picture(0, (PLACE, RED))


def test_an_object_is_visible_again_where_it_is_detected() -> None:
    near, far = PLACE._replace(x=50), PLACE._replace(x=150)
    frame = picture(5, (near, RED), (far, RED))
    found = [Detection(far), Detection(near)]
    (after,), free, log = reidentify([occluded(1, BEFORE, PLACE)], found, frame, config())
    assert after.track.box == pytest.approx(near)
    assert (after.track.status, after.detected, after.last_time) == (
        Status.TRACKING, True, frame.time,
    )  # fmt: skip
    assert after.track.confidence > 0.5
    assert free == [found[0]]
    assert [(each.outcome, each.identity) for each in log] == [(DetectionOutcome.FOUND, 1)]


def test_the_gate_grows_with_time() -> None:
    away = PLACE._replace(x=82)  # three mean half-axes
    for index, reached in ((2, False), (25, True)):
        frame = picture(index, (away, RED))
        _, free, _ = reidentify([occluded(1, BEFORE, PLACE)], [Detection(away)], frame, config())
        assert (not free) == reached


def test_an_object_may_reappear_beside_its_occluder() -> None:
    """The occluder has carried it away, much farther than its own gate reaches."""
    away = PLACE._replace(x=150)
    frame = picture(2, (away, RED))
    occluder = visible(2, frame, away)
    for by, found in ((None, False), (2, True)):
        objects = [occluded(1, BEFORE, PLACE, by), occluder]
        _, free, _ = reidentify(objects, [Detection(away)], frame, config())
        assert (not free) == found


def test_a_detection_of_another_color_is_no_object_that_was_there() -> None:
    away = PLACE._replace(x=60)
    for color, found in ((RED, True), (BLUE, False)):
        frame = picture(2, (away, color))
        _, free, _ = reidentify([occluded(1, BEFORE, PLACE)], [Detection(away)], frame, config())
        assert (not free) == found


def test_visible_objects_get_none() -> None:
    objects, found = [visible(1, BEFORE, PLACE)], [Detection(PLACE)]
    assert reidentify(objects, found, picture(1), config()) == (objects, found, [])
