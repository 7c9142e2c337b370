"""What a user sees go wrong: who got whose identity, and boxes of nobody, of two, or doubled."""

from __future__ import annotations

from collections import Counter
from typing import NamedTuple

import numpy as np

from motes.core import iou
from motes.mot import intersection_over_first
from motes_lab.datasets.distractors import EPSILON, MATCH_IOU, assigned_pairs
from motes_lab.datasets.mot_rows import MotRows

APART = 0.1
"""A box of the results with a smaller overlap with everybody is nobody's."""
INSIDE = 0.7
"""Who has more than this share in a box lies in it."""


class Errors(NamedTuple):
    """Numbers of errors in a sequence."""

    handovers: int
    """How often a track goes on with another person than the one that it was on before."""
    exchanges: int
    """Pairs of hand-overs from one person to another and from that one to the first."""
    ghosts: int
    """Boxes of the results that are nobody's."""
    doubled: int
    """Boxes of the results on a person that another one is matched to."""
    merged: int
    """Boxes of the truth that have no match, and lie in a box that is matched to somebody else."""
    late: int
    """Frames before a person's first match, summed over people who are matched at all."""


def errors(truth: MotRows, results: MotRows) -> Errors:
    """Count the errors; a track is on the person that its box is matched to (`MATCH_IOU`)."""
    on, seen = dict[int, int](), dict[int, int]()
    since = dict(zip(truth.ids[::-1].tolist(), truth.frames[::-1].tolist(), strict=True))
    changes = Counter[tuple[int, int]]()
    ghosts = doubled = merged = 0
    for frame in np.union1d(truth.frames, results.frames).tolist():
        people, rows = truth.at(frame), results.at(frame)
        boxes, found = truth.boxes[people], results.boxes[rows]
        overlaps = iou(boxes[:, None], found)
        i, j = assigned_pairs(np.where(overlaps >= MATCH_IOU - EPSILON, overlaps, 0))
        matched = overlaps[i, j] >= MATCH_IOU - EPSILON
        i, j = i[matched], j[matched]
        free = np.setdiff1d(np.arange(len(found)), j)
        ghosts += int((overlaps[:, free].max(axis=0, initial=0) < APART).sum())
        doubled += int((overlaps[np.ix_(i, free)].max(axis=0, initial=0) >= MATCH_IOU).sum())
        lost = np.setdiff1d(np.arange(len(boxes)), i)
        merged += int(
            (
                intersection_over_first(boxes[lost, None], found[j]).max(axis=1, initial=0) > INSIDE
            ).sum()
        )
        for person, track in zip(truth.ids[people][i], results.ids[rows][j], strict=True):
            seen.setdefault(int(person), frame)
            before = on.get(int(track), int(person))
            changes[before, int(person)] += before != person
            on[int(track)] = int(person)
    exchanges = sum(min(n, changes[b, a]) for (a, b), n in [*changes.items()] if a < b)
    late = sum(frame - since[person] for person, frame in seen.items())
    return Errors(changes.total(), exchanges, ghosts, doubled, merged, late)
