"""Metrics for many objects: CLEAR MOT, identity metrics and HOTA, and errors that a user sees.

The former are counted as in TrackEval, the tool of the MOTChallenge, so that numbers agree with
published ones except for rounding. The counts of a sequence are in one `Tally`. Tallies can be
added; all numbers are computed from the sums, also those over several sequences.
"""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass, fields
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from motes.core import Floats, iou
from motes.mot import intersection_over_first
from motes_lab.datasets.distractors import EPSILON, MATCH_IOU, assigned_pairs
from motes_lab.datasets.mot_rows import MotRows

Integers = NDArray[np.int64]

ALPHAS = np.arange(1, 20) / 20
"""Localization thresholds of HOTA, which is the mean over them."""
MIN_TRACKED = 0.8
"""An object is mostly tracked if it is tracked in more than this share of its frames."""
MAX_LOST = 0.2
"""An object is mostly lost if it is tracked in less than this share of its frames."""
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


@dataclass(frozen=True, slots=True, eq=False)
class Tally:
    """Counts of a comparison of tracks with truth; the properties are shares unless noted."""

    frames: int
    """Number of frames."""
    truths: int
    results: int
    """Numbers of boxes."""
    objects: int
    """Number of identities in the truth."""
    matches: int
    overlap: float
    """Number of boxes matched one to one, and the sum of their overlaps."""
    switches: int
    fragmentations: int
    """How often an object is matched by another track than before; how often it is matched again
    after a gap."""
    mostly_tracked: int
    mostly_lost: int
    """Numbers of objects."""
    handovers: int
    exchanges: int
    ghosts: int
    doubled: int
    merged: int
    late: int
    """As in `Errors`."""
    identified: int
    """Number of matches if each object has one track, and each track one object, for the whole
    sequence."""
    hits: Floats
    associations: Floats
    overlaps: Floats
    """(19,), for each of `ALPHAS`: the number of matches; the sum of A(c) over the matches; the sum
    of their overlaps. A(c) is the share of the boxes of the match's object and track that are
    matches of these two."""

    def __add__(self, other: Tally) -> Tally:
        sums = (getattr(self, f.name) + getattr(other, f.name) for f in fields(self))
        return Tally(*sums)

    @property
    def false_positives(self) -> int:
        """Number of boxes of the results without a match in the truth."""
        return self.results - self.matches

    @property
    def false_negatives(self) -> int:
        """Number of boxes of the truth without a match in the results."""
        return self.truths - self.matches

    @property
    def mota(self) -> float:
        """MOTA = 1 - (FN + FP + switches) / truths; 0 without truth.

        Bernardin and Stiefelhagen, Evaluating multiple object tracking performance: the CLEAR MOT
        metrics, 2008, section 2.1.3.
        """
        if not self.truths:
            return 0.0
        return (self.matches - self.false_positives - self.switches) / self.truths

    @property
    def motp(self) -> float:
        """MOTP as the mean overlap of matches: higher is better, unlike the paper's distances."""
        return self.overlap / max(1, self.matches)

    @property
    def idp(self) -> float:
        """Share of the results' boxes that are identified."""
        return self.identified / max(1, self.results)

    @property
    def idr(self) -> float:
        """Share of the truth's boxes that are identified."""
        return self.identified / max(1, self.truths)

    @property
    def idf1(self) -> float:
        """The harmonic mean of IDP and IDR.

        Ristani et al., Performance measures and a data set for multi-target, multi-camera tracking,
        ECCV workshops 2016.
        """
        return self.identified / max(1, (self.truths + self.results) / 2)

    @property
    def hota(self) -> Floats:
        """HOTA = sqrt(DetA AssA) for each of `ALPHAS`, (19,); the published HOTA is the mean.

        Luiten et al., HOTA: a higher order metric for evaluating multi-object tracking, IJCV 2021,
        equation 15.
        """
        return np.sqrt(self.deta * self.assa)

    @property
    def deta(self) -> Floats:
        """DetA = TP / (TP + FN + FP), the quality of detection, (19,).

        Luiten et al., section 5.3.
        """
        return self.hits / np.maximum(1, self.truths + self.results - self.hits)

    @property
    def assa(self) -> Floats:
        """AssA, the mean of A(c), the quality of association, (19,)."""
        return self.associations / np.maximum(1, self.hits)

    @property
    def loca(self) -> Floats:
        """LocA, the mean overlap of matches, (19,); 1 without matches."""
        return np.where(self.hits > 0, self.overlaps / np.maximum(1, self.hits), 1.0)


class _Frame(NamedTuple):
    """Indices of the objects (m,) and the tracks (n,) in a frame, and their overlaps (m, n)."""

    objects: Integers
    tracks: Integers
    overlaps: Floats


def tally(truth: MotRows, results: MotRows, frames: int) -> Tally:
    """Compare results with truth; in both, a frame has each identity at most once."""
    objects, object_of = np.unique(truth.ids, return_inverse=True)
    tracks, track_of = np.unique(results.ids, return_inverse=True)
    per_frame = []
    for frame in np.union1d(truth.frames, results.frames):
        true_rows, rows = truth.at(frame), results.at(frame)
        overlaps = iou(truth.boxes[true_rows, None], results.boxes[rows])
        per_frame.append(_Frame(object_of[true_rows], track_of[rows], overlaps))
    lengths = np.bincount(object_of, minlength=objects.size)
    track_lengths = np.bincount(track_of, minlength=tracks.size)
    return Tally(
        frames,
        len(truth.frames),
        len(results.frames),
        objects.size,
        *_clear(per_frame, lengths),
        *errors(truth, results),
        _identified(per_frame, lengths, track_lengths),
        *_hota(per_frame, lengths, track_lengths),
    )


def _clear(per_frame: list[_Frame], lengths: Integers) -> tuple[int, float, int, int, int, int]:
    """Count matches, their overlap, switches, fragmentations, objects mostly tracked and lost.

    An object is first matched to its track of the frame before, then all others such that the sum
    of overlaps is largest. Bernardin and Stiefelhagen, section 2.1.2. A frame without results, or
    without truth, is skipped: the frame before it stays the frame before the next one.
    """
    no_track = np.full(lengths.size, -1)
    before, latest = no_track, no_track.copy()  # the track of each object
    tracked, beginnings = np.zeros_like(no_track), np.zeros_like(no_track)
    overlap, switches = 0.0, 0
    for objects, tracks, overlaps in per_frame:
        if not overlaps.size:
            continue
        value = 1000.0 * (tracks == before[objects, None]) + overlaps
        value[overlaps < MATCH_IOU - EPSILON] = 0
        i, j = assigned_pairs(value)
        i, j = i[value[i, j] > 0], j[value[i, j] > 0]
        matched, track = objects[i], tracks[j]
        switches += int(np.count_nonzero((latest[matched] >= 0) & (latest[matched] != track)))
        tracked[matched] += 1
        beginnings[matched] += before[matched] < 0
        latest[matched] = track
        before = no_track.copy()
        before[matched] = track
        overlap += float(overlaps[i, j].sum())
    shares = tracked / lengths
    return (
        int(tracked.sum()),
        overlap,
        switches,
        int(np.maximum(beginnings - 1, 0).sum()),
        int(np.count_nonzero(shares > MIN_TRACKED)),
        int(np.count_nonzero(shares < MAX_LOST)),
    )


def _identified(per_frame: list[_Frame], lengths: Integers, track_lengths: Integers) -> int:
    """Count the matches of the one-to-one assignment of objects to tracks with the most matches.

    Ristani et al., Performance measures and a data set for multi-target, multi-camera tracking,
    ECCV workshops 2016, section 3.
    """
    together = np.zeros((lengths.size, track_lengths.size))
    for objects, tracks, overlaps in per_frame:
        i, j = np.nonzero(overlaps >= MATCH_IOU)
        together[objects[i], tracks[j]] += 1
    return int(together[assigned_pairs(together)].sum())


def _hota(
    per_frame: list[_Frame], lengths: Integers, track_lengths: Integers
) -> tuple[Floats, Floats, Floats]:
    """Count hits, associations and overlaps for each of `ALPHAS`; see `Tally`.

    The matches maximize the sum of overlaps, each weighted by the similarity of its object and
    track over the whole sequence. Luiten et al., section 5.4, equations 17 to 20.
    """
    together = np.zeros((lengths.size, track_lengths.size))
    for objects, tracks, overlaps in per_frame:
        either = overlaps.sum(axis=0) + overlaps.sum(axis=1)[:, None] - overlaps
        together[objects[:, None], tracks] += np.divide(
            overlaps, either, out=np.zeros_like(overlaps), where=either > EPSILON
        )
    similarity = together / (lengths[:, None] + track_lengths - together)
    pairs, found = [np.zeros((2, 0), np.int64)], [np.zeros(0)]
    for objects, tracks, overlaps in per_frame:
        i, j = assigned_pairs(similarity[objects[:, None], tracks] * overlaps)
        pairs.append(np.stack([objects[i], tracks[j]]))
        found.append(overlaps[i, j])
    overlap = np.concatenate(found)
    passed = (overlap[:, None] >= ALPHAS - EPSILON).astype(np.float64)
    (i, j), pair_of = np.unique(np.concatenate(pairs, axis=1), axis=1, return_inverse=True)
    both = np.zeros((i.size, ALPHAS.size))  # number of matches of an object and a track
    np.add.at(both, pair_of.reshape(-1), passed)
    all_boxes = (lengths[i] + track_lengths[j])[:, None] - both
    associations = (both * both / np.maximum(1, all_boxes)).sum(axis=0)
    return passed.sum(axis=0), associations, overlap @ passed


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
