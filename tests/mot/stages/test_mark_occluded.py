"""Which objects are occluded, and by what."""

from __future__ import annotations

import numpy as np
import pytest
from msgspec.structs import replace

from motes.core.geometry import Box
from motes.core.track import Status
from motes.mot.scene_config import Occlusion
from motes.mot.stages.mark_occluded import mark_occluded
from motes.mot.tracked_object import TrackedObject
from scene_objects import DT, RED, occluded, picture, statuses, undetected

PLACE, OVER = Box(40, 30, 20, 40), Box(48, 30, 20, 40)
FRAME = picture(1, (PLACE, RED))


def seen(identity: int, box: Box, distance: float = 0.1) -> TrackedObject:
    """Return an undetected object that its filter recognizes, at a distance from its model."""
    each = undetected(identity, picture(0, (box, RED)), box)
    return replace(each, track=replace(each.track, distance=distance))


def test_a_detected_object_occludes_an_undetected_one() -> None:
    front = seen(2, OVER).detect(OVER, FRAME.time)
    after = mark_occluded([seen(1, PLACE), front], FRAME, Occlusion())
    assert statuses(after) == {1: Status.OCCLUDED, 2: Status.TRACKING}
    assert after[0].occluded_by == 2
    assert after[0].track.confidence == 0


@pytest.mark.parametrize(("first", "second", "hidden"), [(0.3, 0.2, 1), (0.2, 0.3, 2)])
def test_of_two_undetected_objects_the_worse_match_is_occluded(
    first: float, second: float, hidden: int
) -> None:
    after = mark_occluded([seen(1, PLACE, first), seen(2, OVER, second)], FRAME, Occlusion())
    assert [each.identity for each in after if each.occluded] == [hidden]


def test_an_object_that_covers_too_little_occludes_nothing() -> None:
    objects = [seen(1, PLACE), seen(2, OVER).detect(OVER, FRAME.time)]  # 12 of 20 columns
    assert mark_occluded(objects, FRAME, Occlusion(overlap=0.61)) == objects
    assert mark_occluded(objects, FRAME, Occlusion(overlap=0.59))[0].occluded


def test_scenery_occludes_what_fails_the_appearance_rule_or_is_too_long_undetected() -> None:
    each = seen(1, PLACE)
    failed = replace(each, state=replace(each.state, frames_missed=1))
    for undetected_one, frame in ((failed, FRAME), (each, picture(4))):
        (after,) = mark_occluded([undetected_one], frame, Occlusion())
        assert (after.track.status, after.occluded_by) == (Status.OCCLUDED, None)
    assert mark_occluded([each], picture(3), Occlusion()) == [each]  # 0.12 s


def test_detected_objects_are_never_occluded_and_occluded_ones_occlude_nothing() -> None:
    both = [seen(1, PLACE).detect(PLACE, FRAME.time), seen(2, OVER).detect(OVER, FRAME.time)]
    assert mark_occluded(both, FRAME, Occlusion()) == both
    better, worse = seen(1, PLACE, 0.1), seen(2, OVER, 0.2)
    failed = replace(better, state=replace(better.state, frames_missed=1))
    after = mark_occluded([failed, worse], FRAME, Occlusion())
    assert statuses(after) == {1: Status.OCCLUDED, 2: Status.TRACKING}


def test_occluded_objects_go_on_with_their_velocity() -> None:
    before = replace(occluded(1, picture(0, (PLACE, RED)), PLACE), velocity=np.array([50.0, 0.0]))
    (after,) = mark_occluded([before.predict(DT)], FRAME, Occlusion())
    assert after.track.box == pytest.approx(PLACE._replace(x=PLACE.x + 50 * DT))
    assert (after.track.frame, after.track.time) == (FRAME.index, FRAME.time)
