"""Stage 9: the tracks of a frame, and which objects end with it."""

from __future__ import annotations

from collections.abc import Sequence

from motes.core.frame import Frame
from motes.mot.boxes import as_rows, room
from motes.mot.overlaps import CONTAINED, covered_pairs, grouped
from motes.mot.scene_config import SceneConfig, Termination
from motes.mot.tracked_object import SceneTrack, TrackedObject

MAX_AGE_AT_BORDER = 0.2
"""Longest time in seconds for which an occluded object is kept at the border, or outside."""
MIN_MAX_AGE = 0.4
"""Shortest time in seconds for which an occluded object is kept elsewhere."""
COVERED_AGE_FACTOR = 2
"""An object that should be where another one is visible is kept for this many times as long."""


def report(
    objects: Sequence[TrackedObject], frame: Frame, config: SceneConfig
) -> tuple[list[SceneTrack], list[TrackedObject]]:
    """Return the tracks of all objects, and the objects that stay; the others are lost."""
    covers = _covers(objects)
    tracks, staying = list[SceneTrack](), list[TrackedObject]()
    for n, each in enumerate(objects):
        covered = any(not objects[j].occluded for j in covers.get(n, ()))
        max_age = _max_age(each, frame, config.termination, covered=covered)
        if frame.time - each.last_time > max_age:
            tracks.append(each.terminate().scene_track)
        else:
            tracks.append(each.scene_track)
            staying.append(each)
    return tracks, staying


def _covers(objects: Sequence[TrackedObject]) -> dict[int, list[int]]:
    """Return for each occluded object those that cover the place where it should be, as indices."""
    occluded = [n for n, each in enumerate(objects) if each.occluded]
    if not occluded:
        return {}
    boxes = as_rows(each.track.box for each in objects)
    i, j, _ = covered_pairs(boxes[occluded], boxes, CONTAINED)
    return {occluded[k]: others.tolist() for k, others in grouped(i, j).items()}


def _max_age(each: TrackedObject, frame: Frame, config: Termination, *, covered: bool) -> float:
    """Return for how many seconds without a detection an object is kept."""
    if room(each.track.box, frame) <= 0:
        return MAX_AGE_AT_BORDER
    known = max(each.last_time - each.first_time, MIN_MAX_AGE)
    return min(config.max_age, known) * (COVERED_AGE_FACTOR if covered else 1)
