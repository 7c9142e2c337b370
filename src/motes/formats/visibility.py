"""What formats hold and show: aspects of a recording, and objects seen, hidden or guessed."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import replace
from typing import Any

from msgspec import structs

from motes.core.errors import FormatError
from motes.core.track import Status, Track
from motes.formats.recording import ANONYMOUS, Recording
from motes.rows.schema import FrameRow

SHOWN = (Status.TRACKING, Status.INTERPOLATED, Status.OCCLUDED)
"""The statuses with a known position; that of a searched or lost object is only a guess."""
MISSED = (Status.SEARCHING, Status.LOST)
"""The statuses of an object of which it is not known whether it is in the picture."""


def shown(row: FrameRow) -> Iterator[Track]:
    """Yield the objects of a frame whose positions are known, or predicted while hidden."""
    return (each for each in row.objects if each.status in SHOWN)


def visible(row: FrameRow) -> Iterator[Track]:
    """Yield the visible objects of a frame, for formats that cannot mark a hidden one."""
    return (each for each in row.objects if each.visible)


def marked(recorded: Recording, mark: Mapping[str, Any]) -> tuple[Recording, int]:
    """Return a recording whose guesses have the fields of `mark`, and how many there are.

    Confidence 0 is that of an object which a truth does not count. Where the format has no mark for
    these, such an object is hidden beside others that are seen, as distractors are beside people:
    their frame is certain. A frame that shows nothing else is not.
    """
    count = 0

    def told(each: Track, *, beside: bool) -> Track:
        nonlocal count
        if not each.guessed:
            return each
        count += 1
        void = not each.confidence and "confidence" not in mark
        hidden = {"status": Status.OCCLUDED}
        return structs.replace(each, **(hidden if void and beside else mark))

    frames = []
    for row in recorded:
        seen = any(each.visible and not each.guessed for each in row.objects)
        objects = tuple(told(each, beside=seen) for each in row.objects)
        frames.append(structs.replace(row, objects=objects))
    return replace(recorded, frames=frames), count


def certain(recorded: Recording) -> Recording:
    """Return the frames of which it is known what they show: no object is lost or searched for.

    An object that is lost at the edge of the picture and never found again, and whose rows end
    before the film, has left: then these frames are certain.
    """
    last, seen, cut = dict[int, int](), dict[int, int](), dict[int, bool]()
    size = recorded.head.width, recorded.head.height
    for row in recorded:
        last |= dict.fromkeys([*(each.identity for each in row.objects), *row.searched], row.frame)
        others = [each for each in row.objects if each.status is not Status.LOST]
        seen |= dict.fromkeys([*(each.identity for each in others), *row.searched], row.frame)
        cut |= {each.identity: each.box.is_cut(size) for each in others}
    end = max((row.frame for row in recorded), default=0)

    def missed(each: Track, frame: int) -> bool:
        ended = last[each.identity] < end and frame > seen.get(each.identity, -1)
        return each.status in MISSED and not (ended and cut.get(each.identity, True))

    def unsure(row: FrameRow) -> bool:
        return bool(row.searched) or any(missed(each, row.frame) for each in row.objects)

    return replace(recorded, frames=[row for row in recorded if not unsure(row)])


def check_identities(identities: Iterable[int], what: str) -> None:
    """Raise a FormatError if a box has no identity; `what` names a format of tracks."""
    if ANONYMOUS in identities:
        raise FormatError(
            f"{what} holds tracks, and there are boxes without identities; track them first, with "
            "motes watch --detector."
        )


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
