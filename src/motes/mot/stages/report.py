"""Stage 8: the tracks of a frame, and which objects end with it."""

from __future__ import annotations

from collections.abc import Sequence

from motes.core.frame import Frame
from motes.mot.boxes import as_rows, room
from motes.mot.overlaps import CONTAINED, covered_pairs
from motes.mot.scene_config import SceneConfig
from motes.mot.tracked_object import SceneTrack, TrackedObject

MAX_AGE_AT_BORDER = 0.2
"""Longest time in seconds for which an occluded object is kept at the border, or outside."""
COVERED_AGE_FACTOR = 2
"""An object that should be where another one is visible is kept for this many times as long."""


def report(
    objects: Sequence[TrackedObject], frame: Frame, config: SceneConfig
) -> tuple[list[SceneTrack], list[TrackedObject]]:
    """Return the tracks of all objects, and the objects that stay; the others are lost."""
    covered = _covered(objects)
    tracks, staying = list[SceneTrack](), list[TrackedObject]()
    for each in objects:
        max_age = config.termination.max_age
        if room(each.track.box, frame) <= 0:
            max_age = MAX_AGE_AT_BORDER
        elif each.identity in covered:
            max_age *= COVERED_AGE_FACTOR
        if frame.time - each.last_time > max_age:
            tracks.append(each.terminate().scene_track)
        else:
            tracks.append(each.scene_track)
            staying.append(each)
    return tracks, staying


def _covered(objects: Sequence[TrackedObject]) -> set[int]:
    """Return the identities of occluded objects that should be where another one is visible."""
    hidden = [each for each in objects if each.occluded]
    visible = [each for each in objects if not each.occluded]
    places, boxes = (as_rows(each.track.box for each in some) for some in (hidden, visible))
    return {hidden[i].identity for i in covered_pairs(places, boxes, CONTAINED)[0].tolist()}
