"""When those that have met are seen apart again, one assignment says who is who."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np
from msgspec.structs import replace

from motes.core.detection import Detection
from motes.core.frame import Frame
from motes.core.who_is_who import who_is_who
from motes.mot.look import Look, costs, telling
from motes.mot.overlaps import as_rows, grouped, inside, nested_pairs
from motes.mot.tracked_object import TrackedObject

STAY = 3.0
"""Log-likelihood ratio for the identity that an object was followed with, against those that it has
met: its path speaks for it."""

TURNS = 3
"""Frames from one update of a look to the next, for objects that have met nobody; it saves time."""


def tell_apart(
    objects: Sequence[TrackedObject],
    free: Sequence[Detection],
    frame: Frame,
    number: int,
    touching: float,
) -> list[TrackedObject]:
    """Return the objects with the identities that they have from the next frame on.

    Objects that touch are a group, whether they are detected or not, until each has been seen clear
    of the others until its look is settled. An identity keeps its last clear look from before. In
    each frame, the objects of the group that are seen clear are assigned to all of its identities,
    also to those that are hidden or still covered; these then are who is left.

    In the `free` detections, which belong to none, somebody unknown may stand. `number` is how many
    frames there have been before, which tells whose turn it is. Indices do not: a stride leaves
    some out, and so perhaps always the same objects' turns. Objects touch if one covers more than
    the share `touching` of another.
    """
    after, clear = _seen(objects, free, frame, number, touching)
    for group in _groups(after):
        if clear.intersection(group):
            looks = [each.look for each in objects if each.look and each.look.settled]
            _assign(after, group, telling(looks))
    for n, each in enumerate(after):
        if each.seen is not None and not each.met:
            after[n] = replace(each, known=each.seen, seen=None)
    return after


def _seen(
    objects: Sequence[TrackedObject],
    free: Sequence[Detection],
    frame: Frame,
    number: int,
    touching: float,
) -> tuple[list[TrackedObject], set[int]]:
    """Return the objects with their contacts and looks after the frame, and which are clear now."""
    boxes, alive = as_rows(each.box for each in objects), {each.identity for each in objects}
    i, j, _ = nested_pairs(boxes, boxes, touching)
    near = grouped(i[i != j], j[i != j])
    unknown = set(nested_pairs(boxes, as_rows(each.box for each in free), touching)[0].tolist())
    covered = {
        n for n, each in enumerate(objects)
        if each.occluded or not all(objects[m].occluded for m in near.get(n, ()))
    }  # fmt: skip
    whole = inside(boxes, frame)
    detected = {n for n in np.flatnonzero(whole).tolist() if objects[n].detected}
    clear = sorted(detected - covered - unknown)
    met_by = [
        (each.met | {objects[m].identity for m in near.get(n, ())}) & alive
        for n, each in enumerate(objects)
    ]
    learning = [
        n
        for n in clear
        if met_by[n] or objects[n].known is None or (objects[n].identity + number) % TURNS == 0
    ]
    ellipses = [objects[n].track.ellipse for n in learning]
    looks = dict(zip(learning, Look.at(frame, ellipses), strict=True))
    after = list(objects)
    for n, (each, met) in enumerate(zip(objects, met_by, strict=True)):
        known, seen, look = each.known, None if n in covered else each.seen, looks.get(n)
        if look is not None and met:
            seen = look.joined(seen)
        elif look is not None:
            known = look.joined(known)
        if look is not None or met or each.met:
            after[n] = replace(each, met=met, known=known, seen=seen)
    return after, set(clear)


def _groups(objects: Sequence[TrackedObject]) -> Iterator[list[int]]:
    """Yield groups of two or more that have met, directly or through others, as sorted indices."""
    index = {each.identity: n for n, each in enumerate(objects)}
    left = {n for n, each in enumerate(objects) if each.met}
    while left:
        group = [left.pop()]
        for n in group:
            found = {index[identity] for identity in objects[n].met} & left
            left -= found
            group += found
        yield sorted(group)


def _assign(objects: list[TrackedObject], group: list[int], tells: float) -> None:
    """Give the objects of a group the identities that they most likely have, in place.

    `tells` is how much a look tells, from 0 to 1.
    """
    before = [objects[n] for n in group]
    clear = {k: each.seen for k, each in enumerate(before) if each.seen is not None}
    tracks = [*clear]
    likely = costs([*clear.values()], [each.known for each in before], tells)
    likely[range(len(tracks)), tracks] -= STAY
    models, certainty = who_is_who(likely)
    if certainty.min() > 0.5:
        became = dict(zip(models.tolist(), tracks, strict=True))
        now = dict(zip(tracks, models.tolist(), strict=True))
        for k, n in enumerate(group):
            who = now.get(k, k)
            while k not in now and who in became:  # whoever took it leaves an identity
                who = became[who]
            if who != k:
                objects[n] = before[k].with_identity_of(before[who])
    told = {
        objects[n].identity for n in group if (seen := objects[n].seen) is not None and seen.settled
    }
    for n in group:
        if objects[n].identity in told:
            objects[n] = replace(objects[n], met=objects[n].met - told)
