"""Which of the objects without a detection are occluded."""

from __future__ import annotations

from collections.abc import Sequence

from motes.core.frame import Frame
from motes.mot.overlaps import as_rows, grouped, intersection_over_first, occlusion_candidates
from motes.mot.pairs import Integers
from motes.mot.scene_config import Occlusion
from motes.mot.tracked_object import TrackedObject


def mark_occluded(
    objects: Sequence[TrackedObject], frame: Frame, config: Occlusion
) -> list[TrackedObject]:
    """Return the objects, those marked that are occluded, and these where they should be.

    An undetected object is occluded by a visible object that covers it, if that is detected or is
    more similar to its own model. Otherwise, it is occluded by scenery if it does not fulfill the
    appearance rule, or if its last detection is too long ago.
    """
    visible = [each for each in objects if not each.occluded]
    covers = _covers(visible, config.overlap)
    for i, each in enumerate(visible):
        if each.detected:
            continue
        occluder = _occluder(each, [visible[j] for j in covers.get(i, ())])
        overdue = frame.time - each.last_time > config.max_time_without_detection
        if occluder is not None or not each.recognized or overdue:
            visible[i] = each.occlude(occluder)
    marked = iter(visible)
    after = [each if each.occluded else next(marked) for each in objects]
    return [each.extrapolate(frame) if each.occluded else each for each in after]


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
