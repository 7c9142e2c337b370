"""Stage 9: objects that were mistaken for each other during an occlusion swap their identities."""

from __future__ import annotations

from collections.abc import Sequence

from msgspec.structs import replace

from motes.core.frame import Frame
from motes.mot.boxes import as_rows, intersection_over_first
from motes.mot.identity_switch import is_identity_switch
from motes.mot.tracked_object import TrackedObject


def resolve_identity_switches(
    objects: Sequence[TrackedObject], frame: Frame
) -> list[TrackedObject]:
    """Return the objects with the identities that they have from the next frame on.

    An object is compared with the one that last occluded it in the first frame in which both are
    detected and do not overlap.
    """
    after = list(objects)
    index = {each.identity: n for n, each in enumerate(objects)}
    for n in range(len(after)):
        each = after[n]
        if each.occluder_candidate is None:
            continue
        m = index.get(each.occluder_candidate)
        if m is None:  # it is gone
            after[n] = replace(each, occluder_candidate=None)
        elif each.detected and after[m].detected and not _overlap(each, after[m]):
            one, other = replace(each, occluder_candidate=None), after[m]
            if is_identity_switch(one, other, frame):
                one, other = one.with_identity_of(other), other.with_identity_of(one)
                index |= {one.identity: n, other.identity: m}
            after[n], after[m] = one, other
    return after


def _overlap(one: TrackedObject, other: TrackedObject) -> bool:
    """Return whether the boxes of two objects overlap."""
    return bool(intersection_over_first(as_rows([one.track.box]), as_rows([other.track.box])).any())
