"""Of detections of one object, one stays."""

from __future__ import annotations

import math

from motes.core.detection import Detection
from motes.core.geometry import Box
from motes.mot.scene_config import DetectionSelection
from motes.mot.stages.suppress_duplicates import suppress_duplicates
from scene_objects import picture

EMPTY = picture(0)


def test_the_detection_with_the_higher_score_stays() -> None:
    low, high = Detection(Box(20, 20, 20, 40), 0.5), Detection(Box(21, 21, 20, 40), 0.9)
    other = Detection(Box(100, 20, 20, 40), 0.1)
    kept, surplus = suppress_duplicates([low, high, other], EMPTY, DetectionSelection())
    assert (kept, surplus) == ([high, other], 0)


def test_of_equal_scores_the_larger_stays() -> None:
    part, whole = Detection(Box(22, 22, 10, 20)), Detection(Box(20, 20, 20, 40))
    kept, _ = suppress_duplicates([part, whole], EMPTY, DetectionSelection())
    assert kept == [whole]


def test_less_overlap_makes_no_duplicate() -> None:
    for x, kept in ((29, 2), (27, 1)):  # 0.55 and 0.65 of each
        two = [Detection(Box(20, 20, 20, 40)), Detection(Box(x, 20, 20, 40))]
        assert len(suppress_duplicates(two, EMPTY, DetectionSelection())[0]) == kept


def test_what_can_be_no_object_does_not_count_for_the_limit() -> None:
    outside, unknown = Detection(Box(300, 20, 20, 40), 9), Detection(Box(20, 20, 9, 9), math.nan)
    good = [Detection(Box(10 + 30 * i, 20, 20, 40), 1 - i / 9) for i in range(4)]
    config = DetectionSelection(limit=3)
    found = [*good, outside, unknown]
    assert suppress_duplicates(found, EMPTY, config) == (good[:3], 1)
