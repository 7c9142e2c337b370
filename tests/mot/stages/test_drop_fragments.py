"""Parts of visible objects."""

from __future__ import annotations

from motes.core.detection import Detection
from motes.core.geometry import Box
from motes.mot.stages.drop_fragments import drop_fragments
from scene_objects import RED, occluded, picture, visible

PLACE = Box(40, 30, 20, 40)
FRAME = picture(0, (PLACE, RED))


def test_what_lies_in_a_visible_object_is_its_part() -> None:
    inside, around = Detection(Box(42, 34, 10, 10)), Detection(Box(30, 20, 40, 60))
    beside = Detection(Box(55, 30, 20, 40))  # a quarter of each
    free = drop_fragments([visible(7, FRAME, PLACE)], [inside, beside, around])
    assert free == [beside]


def test_what_lies_in_an_occluded_object_is_free() -> None:
    found = [Detection(Box(42, 34, 10, 10))]
    assert drop_fragments([occluded(7, FRAME, PLACE)], found) == found
