"""What may become an object: a detection that others confirm.

Detectors have scores of any scale. The scores of false detections are learned from those that
no other frame confirms. An object needs one detection with a higher score; its other detections may
have any score (Zhang et al., ByteTrack, ECCV 2022, have two such levels as constants).
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

import msgspec
import numpy as np
from msgspec.structs import replace

from motes.core.detection import Detection
from motes.core.geometry import Box, iou
from motes.core.types import Floats
from motes.mot.association import assign_pairs
from motes.mot.overlaps import Overlaps, as_rows, nested_pairs, overlapping_pairs
from motes.mot.scene_config import Initiation

MAX_GAP = 0.3
"""Seconds after which what may become an object is given up if it is not detected any more. After
its first detection, a single frame without one is enough: longer gaps start more false objects."""
LOWEST = 0.1
"""Share of all detections, those with the lowest scores, that begin nothing."""
SURE = 0.99
"""An object's best score is at least this quantile of the scores of unconfirmed detections."""
FEW = 20
"""Least number of unconfirmed detections from which that is learned."""
TOUCHING = 0.3
"""A detection that covers more than this share of an object, or it of that, may be a part of it."""
BUFFER = 0.5
"""How much larger boxes are on each side, as shares of their sizes, where it is not known how fast
an object is. Yang et al., Hard to track objects with irregular motions and similar appearances,
WACV 2023, match such boxes."""
SCORES = 1000
"""Number of latest scores that are kept; a frame with more detections is kept whole."""


class Tentative(NamedTuple):
    """A tentative track."""

    hits: tuple[tuple[float, Box], ...]
    """Times and boxes of its latest detections, oldest first."""
    best: float
    """The highest score of all its detections."""

    def ahead(self, time: float, overlap: float) -> Box:
        """Return where its next detection should be.

        If its last two detections do not overlap, it goes on as between them. Else it is where it
        was: detections tremble more than that.
        """
        now, box = self.hits[-1]
        if len(self.hits) == 1:
            return box
        before, first = self.hits[-2]
        if iou(np.array(first), np.array(box)) >= overlap:
            return box
        steps = (time - now) / (now - before)
        return box._replace(
            x=box.x + steps * (box.x - first.x), y=box.y + steps * (box.y - first.y)
        )


class TrackInitiation(msgspec.Struct, frozen=True):
    """The tentative tracks of a scene."""

    candidates: tuple[Tentative, ...] = ()
    """The tentative tracks: those that the last frame confirmed, and those that it did not, but
    that may still be confirmed."""
    scores: tuple[float, ...] = ()
    """The latest scores of detections, oldest first."""
    confirmed: tuple[float, ...] = ()
    """Of those that belong to objects."""
    unconfirmed: tuple[float, ...] = ()
    """Of those that were given up, and are part of no object."""
    least: float = -math.inf
    """The least score of an object's best detection."""

    def with_scores(
        self, detections: Sequence[Detection], free: Sequence[Detection]
    ) -> TrackInitiation:
        """Return these with the scores of a frame's detections added; free ones have no object.

        Unconfirmed detections are not all false: fast objects are not confirmed either, and have
        scores like others. So the median score of the confirmed ones is always enough.
        """
        left = {id(each) for each in free}
        known = [each.score for each in detections if id(each) not in left]
        scores = _latest(self.scores, [each.score for each in detections])
        confirmed, least = _latest(self.confirmed, known), -math.inf
        if len(self.unconfirmed) >= FEW and confirmed:
            least = float(min(np.quantile(self.unconfirmed, SURE), np.median(confirmed)))
        return replace(self, scores=scores, confirmed=confirmed, least=least)

    def update(
        self,
        time: float,
        free: Sequence[Detection],
        places: Floats,
        overlap: float,
        config: Initiation,
    ) -> tuple[TrackInitiation, list[tuple[Detection, Tentative]]]:
        """Return the tentative tracks after a frame, and the detections that become objects.

        Each comes with its tentative track up to it. The `free` detections belong to no object, and
        `overlap` is their least intersection over union with where they should be. Those with
        `min_hits` hits become objects, and are no candidates any more, if one of these is sure
        enough; one hit less will do if it is surer than those that nothing confirms. A detection
        with one of the lowest scores that confirms nothing is no candidate.

        Parameters
        ----------
        places
            (n, 4), the boxes of all objects.
        """
        before = self.candidates
        boxes = as_rows(each.box for each in free)
        i, j, overlaps = self._pairs(boxes, time, overlap)
        same = assign_pairs(i, j, 1 - overlaps, (len(before), len(free)))
        history = {j: before[i] for i, j in same}
        lowest = np.quantile(self.scores, LOWEST) if free else 0.0
        waiting, over = self._missed({i for i, _ in same}, time)
        begun = list[tuple[Detection, Tentative]]()
        for n, each in enumerate(free):
            hits, best = history.get(n, Tentative((), each.score))
            hits = (*hits, (time, each.box))[-config.min_hits :]
            so_far = Tentative(hits, max(best, each.score))
            surer = so_far.best > self.least > -math.inf
            if each.score < lowest and n not in history:
                over.append(so_far)
            elif len(hits) + surer >= config.min_hits and so_far.best >= self.least:
                begun.append((each, so_far))
            else:
                waiting.append(so_far)
        gone = as_rows(each.hits[-1][1] for each in over)
        parts = set(nested_pairs(gone, places, TOUCHING)[0].tolist())
        alone = [each.best for n, each in enumerate(over) if n not in parts]
        unconfirmed = _latest(self.unconfirmed, alone)
        return replace(self, candidates=tuple(waiting), unconfirmed=unconfirmed), begun

    def _pairs(self, boxes: Floats, time: float, overlap: float) -> Overlaps:
        """Return which detections, boxes (n, 4), may be of which tentative tracks.

        Of one that was detected once it is not known how fast it is.
        """
        places = as_rows(each.ahead(time, overlap) for each in self.candidates)
        once = np.array([len(each.hits) == 1 for each in self.candidates], bool)
        near = overlapping_pairs(places, boxes, overlap)
        far = overlapping_pairs(_buffered(places), _buffered(boxes), overlap)
        of_near, of_far = ~once[near[0]], once[far[0]]
        i, j, overlaps = (
            np.concatenate([a[of_near], b[of_far]]) for a, b in zip(near, far, strict=True)
        )
        return i, j, overlaps

    def _missed(self, found: set[int], time: float) -> tuple[list[Tentative], list[Tentative]]:
        """Return the tentative tracks that a frame did not confirm: who waits, and who is over."""
        waiting, over = list[Tentative](), list[Tentative]()
        for i, each in enumerate(self.candidates):
            if i not in found:
                waits = len(each.hits) > 1 and time - each.hits[-1][0] <= MAX_GAP
                (waiting if waits else over).append(each)
        return waiting, over


def _buffered(boxes: Floats) -> Floats:
    """Return boxes (n, 4) that are larger on each side by `BUFFER`."""
    return np.hstack([boxes[:, :2] - BUFFER * boxes[:, 2:], (1 + 2 * BUFFER) * boxes[:, 2:]])


def _latest(scores: tuple[float, ...], new: Sequence[float]) -> tuple[float, ...]:
    """Return scores with those of a frame added, without the oldest ones."""
    return (*scores, *new)[-max(SCORES, len(new)) :]
