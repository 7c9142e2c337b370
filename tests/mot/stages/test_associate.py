"""Detections of visible objects: of doubles one stays, and what filters observe and learn."""

import math
from typing import Any

import numpy as np
import pytest
from msgspec.structs import replace

from motes import Box, Detection
from motes.mot.look import FRAMES
from motes.mot.scene_config import DetectionSelection, Smoothing
from motes.mot.stages.associate import associate
from motes.mot.stages.suppress_duplicates import suppress_duplicates
from motes.mot.stages.update import update
from motes.mot.tracked_object import REMEMBERED, TrackedObject
from motes.sot.filtering.model_update import ExponentialForgetting
from scene_objects import BLUE, DT, RED, config, occluded, picture, undetected, visible, with_look

LEFT, RIGHT = Box(20, 30, 20, 40), Box(120, 30, 20, 40)
FRAME = picture(1, (LEFT, RED), (RIGHT, BLUE))


def test_each_object_gets_the_detection_that_overlaps_it() -> None:
    objects = [undetected(1, FRAME, LEFT), undetected(2, FRAME, RIGHT)]
    found = [Detection(RIGHT._replace(x=124)), Detection(Box(70, 30, 20, 40)), Detection(LEFT)]
    after, free, _ = associate(objects, found, FRAME, DT, config())
    assert [each.track.box for each in after] == [pytest.approx(LEFT), pytest.approx(found[0].box)]
    assert [each.detected for each in after] == [True, True]
    assert free == [found[1]]
    assert not any(each.detected for each in objects)  # what is given stays as it was


def test_appearance_decides_between_equal_overlaps() -> None:
    """Two objects in one place, and detections as far to either side."""
    middle = Box(60, 30, 20, 40)
    one = undetected(1, picture(0, (middle, RED)), middle)
    other = undetected(2, picture(0, (middle, BLUE)), middle)
    found = [Detection(middle._replace(x=52)), Detection(middle._replace(x=68))]
    for colors, owners in (((RED, BLUE), [1, 2]), ((BLUE, RED), [2, 1])):
        narrow = [each.box._replace(width=8) for each in found]
        frame = picture(1, (narrow[0], colors[0]), (narrow[1]._replace(x=80), colors[1]))
        after, *_ = associate([one, other], found, frame, DT, config())
        assert [each.identity for each in sorted(after, key=lambda each: each.track.box.x)] == (
            owners
        )


@pytest.mark.parametrize(
    ("x", "off", "own"),
    [(20, 1, True), (20, 6, False), (6, -6, True)],  # overlaps of 0.9 and 0.54; at the edge
)
def test_who_looks_like_another_one_covers_an_object_unless_it_is_just_there_or_cut(
    x: int, off: int, own: bool
) -> None:
    at, place = LEFT._replace(x=x), LEFT._replace(x=x + off)
    found, frame = [Detection(place)], picture(1, (place, BLUE))
    for known, expected in ((RED, own), (BLUE, True)):
        before = with_look(undetected(1, picture(0, (at, RED)), at), known)
        (after,), free, covers = associate([before], found, frame, DT, config())
        assert after.detected is expected
        assert free == covers == found * (not expected)
        unsettled = with_look(undetected(1, picture(0, (at, RED)), at), known, FRAMES - 1)
        assert associate([unsettled], found, frame, DT, config())[0][0].detected


def test_velocity_and_size_follow_slowly() -> None:
    still = undetected(1, FRAME, LEFT)
    found = [Detection(Box(22, 32, 24, 40))]  # its center is 4 pixels further, and 2 lower
    scene = replace(config(), smoothing=Smoothing(velocity=0.75, size=0.5))
    (after,), *_ = associate([still], found, FRAME, DT, scene)
    assert after.velocity == pytest.approx([4 / DT / 4, 2 / DT / 4])
    assert after.track.box.width == pytest.approx(22)


def test_a_detection_of_two_objects_is_divided() -> None:
    left, right = Box(50, 30, 20, 40), Box(72, 30, 20, 40)
    frame = picture(1, (left, RED), (right, BLUE))
    objects = [undetected(1, frame, left), undetected(2, frame, right)]
    blob = Detection(Box(48, 30, 47, 40))
    after, free, _ = associate(objects, [blob], frame, DT, config())
    assert [each.track.box.x for each in after] == pytest.approx([50, 72])
    assert free == []


def test_a_detection_is_not_divided_between_parts_that_do_not_fill_it() -> None:
    """Two of 10 x 20 are a sixth of 40 x 60."""
    parts = [Box(24, 30, 10, 20), Box(40, 60, 10, 20)]
    before = [undetected(n, FRAME, part) for n, part in enumerate(parts, start=1)]
    found = [Detection(Box(20, 26, 40, 60))]
    after, free, _ = associate(before, found, FRAME, DT, config())
    assert not any(each.detected for each in after)
    assert free == found


def test_a_part_neither_moves_nor_shrinks_an_object() -> None:
    """A wall hides it from the right: what is seen of it stays behind."""
    moving = replace(undetected(1, FRAME, LEFT), velocity=np.array([100.0, 0.0]))
    left = [Detection(Box(20, 30, 11, 40))]
    (after,), *_ = associate([moving], left, FRAME, DT, config())
    assert after.velocity == pytest.approx([100, 0])
    hidden = after.occlude(None).extrapolate(FRAME)
    assert hidden.track.box[2:] == pytest.approx(LEFT[2:])
    for _ in range(round(REMEMBERED / DT) + 2):  # or it is as small as that
        (after,), *_ = associate([after.predict(DT)], left, FRAME, DT, config())
    assert after.occlude(None).extrapolate(FRAME).track.box.width == pytest.approx(11, abs=1)


def test_occluded_objects_get_none_and_observe_nothing() -> None:
    objects, found = [occluded(1, FRAME, LEFT)], [Detection(LEFT)]
    assert associate(objects, found, FRAME, DT, config()) == (objects, found, [])
    assert update(objects, picture(1), DT) == objects


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


EMPTY = picture(0)


WHOLE = Detection(Box(20, 20, 20, 40), 0.5)


@pytest.mark.parametrize(
    ("other", "kept"),
    [
        (Detection(Box(21, 21, 20, 40), 0.9), [1]),  # the higher score stays
        (Detection(Box(22, 22, 10, 20), 0.5), [0]),  # and of equal ones the larger
        (Detection(Box(27, 20, 20, 40), 0.5), [0]),  # 0.65 of each is shared
        (Detection(Box(29, 20, 20, 40), 0.5), [0, 1]),  # 0.55
    ],
)
def test_of_two_that_overlap_one_stays(other: Detection, kept: list[int]) -> None:
    two = [WHOLE, other]
    found, surplus = suppress_duplicates(two, EMPTY, DetectionSelection())
    assert (found, surplus) == ([two[i] for i in kept], 0)


def test_what_can_be_no_object_does_not_count_for_the_limit() -> None:
    outside, unknown = Detection(Box(300, 20, 20, 40), 9), Detection(Box(20, 20, 9, 9), math.nan)
    good = [Detection(Box(10 + 30 * i, 20, 20, 40), 1 - i / 9) for i in range(4)]
    config = DetectionSelection(limit=3)
    found = [*good, outside, unknown]
    assert suppress_duplicates(found, EMPTY, config) == (good[:3], 1)
