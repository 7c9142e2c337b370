"""The filters of visible objects observe the frame."""

from __future__ import annotations

from collections.abc import Sequence

from motes.core.frame import Frame
from motes.mot.overlaps import as_rows, occlusion_candidates
from motes.mot.tracked_object import TrackedObject


def update(objects: Sequence[TrackedObject], frame: Frame, dt: float) -> list[TrackedObject]:
    """Return the objects after a step of the filters of all that are visible.

    While another object is so near that one may occlude the other, an object's models do not
    learn.
    """
    after = list(objects)
    visible = [n for n, each in enumerate(objects) if not each.occluded]
    pairs = occlusion_candidates(as_rows(objects[n].predicted.box for n in visible))
    meeting = set(pairs[0].tolist())
    for i, n in enumerate(visible):
        after[n] = objects[n].observe(frame, dt, learn=i not in meeting)
    return after
