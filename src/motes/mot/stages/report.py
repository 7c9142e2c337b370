"""The tracks of a frame, and which objects end with it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from msgspec.structs import replace

from motes.core.frame import Frame
from motes.core.track import Status, Track
from motes.mot.overlaps import CONTAINED, as_rows, best_partners, covered_pairs
from motes.mot.scene_config import SceneConfig
from motes.mot.tracked_object import TrackedObject

MAX_AGE_AT_BORDER = 0.2
"""Longest time in seconds for which an occluded object is kept at the border, or outside."""
COVERED_AGE_FACTOR = 2
"""An object that should be where another one is visible is kept for this many times as long."""


def report(
    objects: Sequence[TrackedObject], frame: Frame, least: float, config: SceneConfig
) -> tuple[list[Track], list[TrackedObject]]:
    """Return the tracks of all objects, and the objects that stay; the others are gone.

    An object is gone if it was not detected for too long, or never with at least the score `least`.
    One that is not seen is occluded if a visible one covers enough of it. In plain sight, or
    behind scenery, of which nothing is known, it is lost, and sought as long as it stays.
    """
    hidden = [each for each in objects if each.occluded]
    visible = [each for each in objects if not each.occluded]
    places, boxes = (as_rows(each.box for each in some) for some in (hidden, visible))
    i, j, shares = covered_pairs(places, boxes, config.occlusion.overlap)
    occluders = {
        hidden[n].identity: visible[m].identity for n, m in best_partners(i, j, shares).items()
    }
    covered = {hidden[n].identity for n in i[shares > CONTAINED].tolist()}
    tracks, staying = list[Track](), list[TrackedObject]()
    for each in objects:
        max_age = config.termination.max_age
        if each.box.room(frame.width, frame.height) <= 0:
            max_age = MAX_AGE_AT_BORDER
        elif each.identity in covered:
            max_age *= COVERED_AGE_FACTOR
        if frame.time - each.last_time > max_age or each.best < least:
            tracks.append(each.terminate().public_track)
        else:
            tracks.append(_told(each, occluders))
            staying.append(each)
    return tracks, staying


def _told(each: TrackedObject, occluders: Mapping[int, int]) -> Track:
    """Return the track of an object that stays, from the identities of all occluders."""
    track, occluder = each.public_track, occluders.get(each.identity)
    if not each.occluded or occluder is not None:
        return replace(track, occluded_by=occluder)
    return replace(track, status=Status.LOST, occluded_by=None, sought=True)
