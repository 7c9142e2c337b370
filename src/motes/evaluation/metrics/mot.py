"""How well tracks fit the truth where there are many objects: CLEAR, identity and HOTA metrics.

Each is counted as TrackEval does, which the MOTChallenge uses, so that numbers agree with published
ones to rounding. All of a sequence is counted in one `Tally`; tallies add up, and every number is
made from the sums, also those over several sequences.
"""

from __future__ import annotations

from dataclasses import dataclass, fields
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from motes.core.geometry import iou
from motes.evaluation.datasets.distractors import _TINY, MATCHED, assigned_pairs
from motes.evaluation.datasets.mot_files import Rows

Floats = NDArray[np.float64]
Integers = NDArray[np.int64]

ALPHAS = np.arange(1, 20) / 20
"""The same for HOTA, which is a mean over all of these."""
MOSTLY = 0.8
"""An object is mostly tracked in more than this share of its frames."""
HARDLY = 0.2
"""An object is mostly lost if tracked in less than this share of its frames."""


@dataclass(frozen=True, slots=True, eq=False)
class Tally:
    """What is counted of tracks and truth; numbers are shares unless they say otherwise.

    Attributes
    ----------
    frames
        How many there are.
    truths, results
        Numbers of boxes.
    objects
        Number of identities in the truth.
    matches, overlap
        Boxes matched one to one, and the sum of their overlaps.
    switches, fragmentations
        How often an object is matched by another track than before; is matched again after it was
        not.
    mostly_tracked, mostly_lost
        Numbers of objects.
    identified
        Matches if each object has one track, and each track one object, for the whole sequence.
    hits, associations, overlaps
        (19,), for each of `ALPHAS`: matches; the sum over them of A(c), the share of the boxes of
        its object and track that are matches of these two; the sum over them of overlaps.
    """

    frames: int
    truths: int
    results: int
    objects: int
    matches: int
    overlap: float
    switches: int
    fragmentations: int
    mostly_tracked: int
    mostly_lost: int
    identified: int
    hits: Floats
    associations: Floats
    overlaps: Floats

    def __add__(self, other: Tally) -> Tally:
        sums = (getattr(self, f.name) + getattr(other, f.name) for f in fields(self))
        return Tally(*sums)

    @property
    def false_positives(self) -> int:
        """Boxes of the results that are matched with none of the truth."""
        return self.results - self.matches

    @property
    def false_negatives(self) -> int:
        """Boxes of the truth that are matched with none of the results."""
        return self.truths - self.matches

    @property
    def mota(self) -> float:
        """MOTA = 1 - (FN + FP + switches) / truths, with 0 where there is no truth.

        Bernardin and Stiefelhagen, Evaluating multiple object tracking performance: the CLEAR MOT
        metrics, 2008, section 2.1.3.
        """
        if not self.truths:
            return 0.0
        return (self.matches - self.false_positives - self.switches) / self.truths

    @property
    def motp(self) -> float:
        """MOTP, the mean overlap of matches; more is better, unlike with the paper's distances."""
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
        """Their harmonic mean. Ristani et al., Performance measures and a data set for …, 2016."""
        return self.identified / max(1, (self.truths + self.results) / 2)

    @property
    def hota(self) -> Floats:
        """HOTA = sqrt(DetA AssA) for each of `ALPHAS`; HOTA itself is the mean.

        Luiten et al., HOTA: a higher order metric for evaluating multi-object tracking, IJCV 2021,
        equation 15.
        """
        return np.sqrt(self.deta * self.assa)

    @property
    def deta(self) -> Floats:
        """DetA = TP / (TP + FN + FP), how well objects are found, (19,); their section 5.3."""
        return self.hits / np.maximum(1, self.truths + self.results - self.hits)

    @property
    def assa(self) -> Floats:
        """AssA, the mean of A(c), how well identities are kept, (19,)."""
        return self.associations / np.maximum(1, self.hits)

    @property
    def loca(self) -> Floats:
        """LocA, the mean overlap of matches, (19,); 1 where there are none."""
        return np.where(self.hits > 0, self.overlaps / np.maximum(1, self.hits), 1.0)


class _Frame(NamedTuple):
    """Whose the boxes of the truth (m,) and the results (n,) are, and how they overlap (m, n)."""

    objects: Integers
    tracks: Integers
    overlaps: Floats


def tally(truth: Rows, results: Rows, frames: int) -> Tally:
    """Count what results are worth; both have no identity twice in a frame.

    Raises
    ------
    MissingDependencyError
        If scipy is not installed.
    """
    objects, whose = np.unique(truth.ids, return_inverse=True)
    tracks, by = np.unique(results.ids, return_inverse=True)
    film = []
    for frame in np.union1d(truth.frames, results.frames):
        there, said = truth.at(frame), results.at(frame)
        overlaps = iou(truth.boxes[there, None], results.boxes[said])
        film.append(_Frame(whose[there], by[said], overlaps))
    lengths = np.bincount(whose, minlength=objects.size), np.bincount(by, minlength=tracks.size)
    return Tally(
        frames, len(truth.frames), len(results.frames), objects.size,
        *_clear(film, lengths[0]), _identified(film, *lengths), *_hota(film, *lengths),
    )  # fmt: skip


def _clear(film: list[_Frame], lengths: Integers) -> tuple[int, float, int, int, int, int]:
    """Count matches, their overlap, switches, fragmentations, objects mostly tracked and lost.

    An object and its track of the frame before are matched first, then all others so that their
    overlaps are largest. Bernardin and Stiefelhagen, section 2.1.2. A frame without any results, or
    any truth, is passed over: what is the frame before stays so.
    """
    nobody = np.full(lengths.size, -1)
    before, latest = nobody, nobody.copy()  # the track of each object
    tracked, beginnings = np.zeros_like(nobody), np.zeros_like(nobody)
    overlap, switches = 0.0, 0
    for objects, tracks, overlaps in film:
        if not overlaps.size:
            continue
        worth = 1000.0 * (tracks == before[objects, None]) + overlaps
        worth[overlaps < MATCHED - _TINY] = 0
        i, j = assigned_pairs(worth)
        i, j = i[worth[i, j] > 0], j[worth[i, j] > 0]
        who, by = objects[i], tracks[j]
        switches += int(np.count_nonzero((latest[who] >= 0) & (latest[who] != by)))
        tracked[who] += 1
        beginnings[who] += before[who] < 0
        latest[who] = by
        before = nobody.copy()
        before[who] = by
        overlap += float(overlaps[i, j].sum())
    shares = tracked / lengths
    return (
        int(tracked.sum()),
        overlap,
        switches,
        int(np.maximum(beginnings - 1, 0).sum()),
        int(np.count_nonzero(shares > MOSTLY)),
        int(np.count_nonzero(shares < HARDLY)),
    )


def _identified(film: list[_Frame], lengths: Integers, track_lengths: Integers) -> int:
    """Count the matches of the one-to-one assignment of objects to tracks that has most of them.

    Ristani et al., Performance measures and a data set for multi-target, multi-camera tracking,
    ECCV workshops 2016, section 3.
    """
    together = np.zeros((lengths.size, track_lengths.size))
    for objects, tracks, overlaps in film:
        i, j = np.nonzero(overlaps >= MATCHED)
        together[objects[i], tracks[j]] += 1
    return int(together[assigned_pairs(together)].sum())


def _hota(
    film: list[_Frame], lengths: Integers, track_lengths: Integers
) -> tuple[Floats, Floats, Floats]:
    """Count hits, associations and overlaps for each of `ALPHAS`; see `Tally`.

    Matches are those of the largest sum of overlaps, each weighted by how much its object and track
    go together in the whole sequence. Luiten et al., section 5.4, equations 17 to 20.
    """
    together = np.zeros((lengths.size, track_lengths.size))
    for objects, tracks, overlaps in film:
        either = overlaps.sum(axis=0) + overlaps.sum(axis=1)[:, None] - overlaps
        together[objects[:, None], tracks] += np.divide(
            overlaps, either, out=np.zeros_like(overlaps), where=either > _TINY
        )
    alike = together / (lengths[:, None] + track_lengths - together)
    pairs, found = [np.zeros((2, 0), np.int64)], [np.zeros(0)]
    for objects, tracks, overlaps in film:
        i, j = assigned_pairs(alike[objects[:, None], tracks] * overlaps)
        pairs.append(np.stack([objects[i], tracks[j]]))
        found.append(overlaps[i, j])
    overlap = np.concatenate(found)
    passed = (overlap[:, None] >= ALPHAS - _TINY).astype(np.float64)
    (who, by), kind = np.unique(np.concatenate(pairs, axis=1), axis=1, return_inverse=True)
    both = np.zeros((who.size, ALPHAS.size))  # matches of an object and a track
    np.add.at(both, kind.reshape(-1), passed)
    all_boxes = (lengths[who] + track_lengths[by])[:, None] - both
    associations = (both * both / np.maximum(1, all_boxes)).sum(axis=0)
    return passed.sum(axis=0), associations, overlap @ passed
