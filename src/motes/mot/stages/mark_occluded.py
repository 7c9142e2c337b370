"""Which of the objects without a detection are occluded, and which a detector has missed."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from motes.core.frame import Frame
from motes.mot.association import look_costs
from motes.mot.look import probability_of_one
from motes.mot.overlaps import as_rows, grouped, intersection_over_first, occlusion_candidates
from motes.mot.pairs import Integers
from motes.mot.scene_config import Occlusion
from motes.mot.tracked_object import TrackedObject


def mark_occluded(
    objects: Sequence[TrackedObject], frame: Frame, config: Occlusion
) -> list[TrackedObject]:
    """Return the objects, those marked that are occluded, and these where they should be.

    An undetected object is visible as long as it looks, where it should be, as it did when it was
    last clear of others: detectors miss objects in plain sight. One of which no such look is known
    is occluded by a visible object that covers it, if that is detected or is more similar to its
    own model. Otherwise, it is occluded by scenery if it does not fulfill the appearance rule, or
    if its last detection is too long ago.
    """
    likeness = _likeness(objects, frame)
    seen = {n for n, probability in likeness.items() if probability > 0.5}
    after = [each.in_sight(frame, likeness[n]) if n in seen else each for n, each in enumerate(objects)]
    visible = [n for n, each in enumerate(after) if not each.occluded]
    covers = _covers([after[n] for n in visible], config.overlap)
    for i, n in enumerate(visible):
        each = after[n]
        if each.detected or n in seen:
            continue
        occluder = _occluder(each, [after[visible[j]] for j in covers.get(i, ())])
        overdue = frame.time - each.last_time > config.max_time_without_detection
        if n in likeness or occluder is not None or not each.recognized or overdue:
            after[n] = each.occlude(occluder)
    return [each.extrapolate(frame) if each.occluded else each for each in after]


def _likeness(objects: Sequence[TrackedObject], frame: Frame) -> dict[int, float]:
    """Return the probability that what is where an object should be is the object, by its index.

    Only of undetected objects of which it is known how they look.
    """
    looks = {
        n: each.look
        for n, each in enumerate(objects)
        if not each.detected and each.look is not None and each.look.settled
    }
    boxes, own = as_rows(objects[n].predicted.box for n in looks), np.arange(len(looks))
    costs = look_costs([*looks.values()], frame, boxes, own, own)
    return dict(zip(looks, map(probability_of_one, costs.tolist()), strict=True))


def _covers(visible: Sequence[TrackedObject], overlap: float) -> dict[int, Integers]:
    """Return for each object the others that cover more than a share of it, as indices."""
    boxes = as_rows(each.box for each in visible)
    rows, columns = occlusion_candidates(boxes)
    covered = intersection_over_first(boxes[rows], boxes[columns]) > overlap
    return grouped(rows[covered], columns[covered])


def _occluder(each: TrackedObject, covers: Sequence[TrackedObject]) -> int | None:
    """Return the identity of the object that occludes one, of those that cover it, or None."""
    for other in covers:
        if not other.occluded and (other.detected or other.track.distance < each.track.distance):
            return other.identity
    return None
