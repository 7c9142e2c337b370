"""Stage 6: free detections on visible objects are parts of these."""

from __future__ import annotations

from collections.abc import Sequence

from motes.core.detection import Detection
from motes.mot.boxes import as_rows
from motes.mot.overlaps import CONTAINED, nested_pairs
from motes.mot.tracked_object import TrackedObject


def drop_fragments(objects: Sequence[TrackedObject], free: Sequence[Detection]) -> list[Detection]:
    """Return the detections that are no part of a visible object.

    A detection is a part of an object if one box lies in the other.
    """
    visible = [each for each in objects if not each.occluded]
    if not visible or not free:
        return list(free)
    boxes, places = as_rows(each.box for each in free), as_rows(t.track.box for t in visible)
    parts = set(nested_pairs(boxes, places, CONTAINED)[0].tolist())
    return [each for i, each in enumerate(free) if i not in parts]
