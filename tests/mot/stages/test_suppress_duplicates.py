"""Of detections of one object, one stays."""

from __future__ import annotations

import math

import pytest

from motes.core.detection import Detection
from motes.core.geometry import Box
from motes.mot.scene_config import DetectionSelection
from motes.mot.stages.suppress_duplicates import suppress_duplicates
from scene_objects import picture

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
