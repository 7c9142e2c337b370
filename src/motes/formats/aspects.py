"""What some formats hold and others do not, and what of it a recording has."""

from __future__ import annotations

import math

from motes.core.track import Status
from motes.formats.recording import Recording
from motes.formats.visibility import SHOWN

ANGLES = "angles"
CONFIDENCES = "confidences"
IDENTITIES = "identities"
CLASSES = "classes"
HIDDEN = "hidden objects"
GUESSES = "guessed places of searched and lost targets"
MASKS = "masks"
TIMES = "times"
OTHERS = "further columns"
ASPECTS = (ANGLES, CONFIDENCES, IDENTITIES, CLASSES, HIDDEN, GUESSES, MASKS, TIMES, OTHERS)
"""All of them, beside the boxes in each frame, which every format holds."""


def aspects(recorded: Recording) -> set[str]:
    """Return those of `ASPECTS` that a recording has."""
    found = {TIMES} if recorded.timed else set[str]()
    for row in recorded:
        for each in (each for each in row.objects if each.placed):
            held = {
                ANGLES: each.ellipse.theta != 0 and each.ellipse.a != each.ellipse.b,
                CONFIDENCES: each.confidence != 1,
                IDENTITIES: each.identity > 1,
                CLASSES: each.label not in (None, recorded.head.label),
                HIDDEN: each.status is Status.OCCLUDED,
                GUESSES: each.status not in SHOWN,
                MASKS: each.mask is not None,
                OTHERS: bool(each.further) or math.isfinite(each.distance),
            }
            found.update(name for name, has in held.items() if has)
    return found
