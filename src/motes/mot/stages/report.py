"""Stage 8: the tracks of a frame, and which objects end with it."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from motes.core.frame import Frame
from motes.mot.boxes import as_rows, room
from motes.mot.overlaps import CONTAINED, covered_pairs
from motes.mot.scene_config import SceneConfig
from motes.mot.tracked_object import SceneTrack, TrackedObject

MAX_AGE_AT_BORDER = 0.2
"""Longest time in seconds for which an occluded object is kept at the border, or outside."""
COVERED_AGE_FACTOR = 2
"""An object that should be where another one is visible is kept for this many times as long."""

LOWEST = 0.1
"""Share of the scores of objects that have moved, the lowest, that are doubtful for one that has
not."""
ENOUGH, LATEST = 200, 1000
"""Numbers of such scores from which this is told, and that are kept."""


def report(
    objects: Sequence[TrackedObject],
    frame: Frame,
    config: SceneConfig,
    trusted: Sequence[float] = (),
) -> tuple[list[SceneTrack], list[TrackedObject]]:
    """Return the tracks of the objects, and the objects that stay; the others are lost.

    What has never moved, and has lower scores than most that have, has no track: a poster or a
    bush that a detector takes for somebody. It stays an object, to which its detections go.

    Parameters
    ----------
    objects, frame, config
        As they are now.
    trusted
        The latest mean scores of objects that have moved; see `trust`.
    """
    least = np.quantile(trusted, LOWEST) if len(trusted) >= ENOUGH else -np.inf
    covered = _covered(objects)
    tracks, staying = list[SceneTrack](), list[TrackedObject]()
    for each in objects:
        max_age = config.termination.max_age
        if room(each.track.box, frame) <= 0:
            max_age = MAX_AGE_AT_BORDER
        elif each.identity in covered:
            max_age *= COVERED_AGE_FACTOR
        lost = frame.time - each.last_time > max_age
        if each.moved or each.score >= least:
            tracks.append((each.terminate() if lost else each).scene_track)
        if not lost:
            staying.append(each)
    return tracks, staying


def trust(trusted: tuple[float, ...], objects: Sequence[TrackedObject]) -> tuple[float, ...]:
    """Return the latest mean scores of objects that have moved, with those detected now."""
    now = [each.score for each in objects if each.moved and each.detected]
    return (*trusted, *(score for score in now if math.isfinite(score)))[-LATEST:]


def _covered(objects: Sequence[TrackedObject]) -> set[int]:
    """Return the identities of occluded objects that should be where another one is visible."""
    hidden = [each for each in objects if each.occluded]
    visible = [each for each in objects if not each.occluded]
    places, boxes = (as_rows(each.track.box for each in some) for some in (hidden, visible))
    return {hidden[i].identity for i in covered_pairs(places, boxes, CONTAINED)[0].tolist()}
