"""Filters observe the frame, and learn only where no other object is near."""

from __future__ import annotations

from typing import Any

from msgspec.structs import replace

from motes.core.geometry import Box
from motes.mot.stages.update import update
from motes.mot.tracked_object import TrackedObject
from motes.sot.filtering.model_update import ExponentialForgetting
from scene_objects import BLUE, DT, RED, occluded, picture, visible

PLACE, FAR, NEAR = Box(40, 30, 20, 40), Box(140, 30, 20, 40), Box(64, 30, 20, 40)


def learning(identity: int, box: Box) -> TrackedObject:
    """Return an object that learns quickly, detected in the next frame."""
    begun = visible(identity, picture(0, (box, RED)), box)
    tracker = replace(begun.tracker, adaptation=ExponentialForgetting(learning_rate=0.5))
    return replace(begun, tracker=tracker).predict(DT).detect(box, DT)


def histogram(each: TrackedObject) -> list[float]:
    """Return its color model."""
    model: Any = each.state.models["color"]
    values: list[float] = model.histogram.tolist()
    return values


def test_models_learn_only_while_no_other_object_is_near() -> None:
    frame = picture(1, (PLACE, RED), (PLACE._replace(height=10), BLUE))  # still mostly red
    for other, near in ((FAR, False), (NEAR, True)):
        before = learning(1, PLACE)
        after, _ = update([before, learning(2, other)], frame, DT)
        assert (histogram(after) == histogram(before)) == near


def test_a_detected_object_stays_at_its_detection_and_others_follow_their_filter() -> None:
    frame = picture(1, (PLACE._replace(x=43), RED))
    detected = learning(1, PLACE)
    alone = replace(detected, detected=False)
    for each, moves in ((detected, False), (alone, True)):
        (after,) = update([each], frame, DT)
        assert (after.track.ellipse != each.track.ellipse) == moves
        assert after.track.frame == 1


def test_occluded_objects_observe_nothing() -> None:
    objects = [occluded(1, picture(0, (PLACE, RED)), PLACE)]
    assert update(objects, picture(1), DT) == objects
