"""Which of the objects without a detection are occluded, and which a detector has missed."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import chain

from motes.core.frame import Frame
from motes.core.geometry import Ellipse
from motes.mot.look import Look, costs, probability_of_one
from motes.mot.overlaps import as_rows, grouped, intersection_over_first, occlusion_candidates
from motes.mot.pairs import Integers
from motes.mot.scene_config import Occlusion
from motes.mot.tracked_object import TrackedObject

STEP = 0.3
"""How far beside where it should be an object is looked for, in its smaller half-axes."""
STEPS = ((0, 0), (-1, 0), (1, 0), (0, -1), (0, 1))
"""The place itself comes first."""
ASIDE = 1.0
"""Cost of a step: else it stays behind with the part of it that somebody does not cover yet."""


def mark_occluded(
    objects: Sequence[TrackedObject], frame: Frame, config: Occlusion, *, looked: bool = True
) -> list[TrackedObject]:
    """Return the objects, those marked that are occluded, and these where they should be.

    An undetected object is visible as long as it looks, about where it should be, as it did when it
    was last clear of others: detectors miss objects in plain sight. One of which no such look is
    known is occluded by a visible object that covers it, if that is detected or is more similar to
    its own model. Otherwise, it is occluded by scenery if it does not fulfill the appearance rule,
    or if its last detection is too long ago.

    In a frame at which the detector has not `looked` nobody is missed: a visible object is occluded
    only by one that covers it. Else it is where its filter recognizes it, or where it should be.
    """
    found = _found(objects, frame)
    after = [found.get(n) or each for n, each in enumerate(objects)]
    covers = _covers(after, config.overlap)
    for n, each in enumerate(after):
        if each.occluded or each.detected or found.get(n):
            continue
        occluder = _occluder(each, [after[m] for m in covers.get(n, ())])
        overdue = frame.time - each.last_time > config.max_time_without_detection
        missed = looked and (n in found or not each.recognized or overdue)
        if missed or occluder is not None:
            after[n] = each.occlude(occluder)
        elif not each.recognized:
            after[n] = each.in_sight(frame, each.predicted)
    return [each.extrapolate(frame) if each.occluded else each for each in after]


def _found(objects: Sequence[TrackedObject], frame: Frame) -> dict[int, TrackedObject | None]:
    """Return the undetected objects of which it is known how they look, by their indices.

    Each is where it looks most like itself, of where it should be and a step to each side; it is
    None if it looks like another one there, too.
    """
    looks = {
        n: each.look for n, each in enumerate(objects) if not each.detected and each.found_by_look
    }
    places = [_about(objects[n].predicted) for n in looks]
    seen = Look.at(frame, [*chain.from_iterable(places)])
    found = dict[int, TrackedObject | None]()
    for (n, look), around, first in zip(
        looks.items(), places, range(0, len(seen), len(STEPS)), strict=True
    ):
        unlikely = costs(seen[first : first + len(STEPS)], [look])[:, 0]
        unlikely[1:] += ASIDE
        best = int(unlikely.argmin())
        place, is_it = around[best], probability_of_one(float(unlikely[best]))
        found[n] = objects[n].in_sight(frame, place) if is_it > 0.5 else None
    return found


def _about(place: Ellipse) -> list[Ellipse]:
    """Return a place, and those a step to each side of it."""
    step = STEP * min(place.a, place.b)
    return [place._replace(x=place.x + step * x, y=place.y + step * y) for x, y in STEPS]


def _covers(objects: Sequence[TrackedObject], overlap: float) -> dict[int, Integers]:
    """Return for each object the others that cover more than a share of it, as indices."""
    boxes = as_rows(each.box for each in objects)
    rows, columns = occlusion_candidates(boxes)
    covered = intersection_over_first(boxes[rows], boxes[columns]) > overlap
    return grouped(rows[covered], columns[covered])


def _occluder(each: TrackedObject, covers: Sequence[TrackedObject]) -> int | None:
    """Return the identity of the object that occludes one, of those that cover it, or None."""
    for other in covers:
        if not other.occluded and (other.detected or other.track.distance < each.track.distance):
            return other.identity
    return None
