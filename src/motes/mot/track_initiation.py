"""What may become an object: a detection that others confirm.

A detection with a low score begins nothing, but it confirms what a surer one has begun: Zhang et
al., ByteTrack, ECCV 2022, use such detections for known objects.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TypeAlias

import msgspec
import numpy as np
from msgspec.structs import replace

from motes.core.detection import Detection
from motes.core.geometry import Box
from motes.mot.assignment import assign_pairs
from motes.mot.boxes import as_rows
from motes.mot.overlaps import overlapping_pairs
from motes.mot.scene_config import Initiation

Tentative: TypeAlias = tuple[tuple[float, Box], ...]
"""The hits of a tentative track, oldest first: times and boxes of detections."""

MAX_GAP = 0.3
"""Seconds after which what may become an object is given up if it is not detected any more. After
its first detection, a single frame without one is enough: longer gaps start more false objects."""
LOWEST = 0.1
"""Share of all detections, those with the lowest scores, that begin nothing."""
SCORES = 1000
"""Number of latest scores that are kept; a frame with more detections is kept whole."""


class TrackInitiation(msgspec.Struct, frozen=True):
    """The tentative tracks of a scene."""

    candidates: tuple[Tentative, ...] = ()
    """The tentative tracks: those that the last frame confirmed, and those that it did not, but
    that may still be confirmed."""
    scores: tuple[float, ...] = ()
    """The latest scores of detections, oldest first."""

    def with_scores(self, detections: Sequence[Detection]) -> TrackInitiation:
        """Return these with the scores of all detections of a frame added."""
        scores = (*self.scores, *(each.score for each in detections))
        return replace(self, scores=scores[-max(SCORES, len(detections)) :])

    def update(
        self, time: float, free: Sequence[Detection], overlap: float, config: Initiation
    ) -> tuple[TrackInitiation, list[tuple[Detection, Tentative]]]:
        """Return the tentative tracks after a frame, and the detections that become objects.

        Each comes with the hits up to it.

        Parameters
        ----------
        time
            Of the frame, in seconds.
        free
            The detections that belong to no object.
        overlap
            Least intersection over union of a detection with the one before.
        config
            Detections with `min_hits` hits become objects, and are no candidates any more. A
            detection with one of the lowest scores that confirms nothing is no candidate.
        """
        before = self.candidates
        boxes = as_rows(each.box for each in free)
        latest = as_rows(candidate[-1][1] for candidate in before)
        i, j, overlaps = overlapping_pairs(latest, boxes, overlap)
        same = assign_pairs(i, j, 1 - overlaps, (len(before), len(free)))
        history = {j: before[i] for i, j in same}
        least = np.quantile(self.scores, LOWEST) if free else 0.0
        hits = [
            (each, (*history.get(j, ()), (time, each.box)))
            for j, each in enumerate(free)
            if each.score >= least or j in history
        ]
        begun = [(each, so_far) for each, so_far in hits if len(so_far) >= config.min_hits]
        confirmed = {i for i, _ in same}
        waiting = [
            each
            for i, each in enumerate(before)
            if i not in confirmed and len(each) > 1 and time - each[-1][0] <= MAX_GAP
        ]
        tentative = [so_far for _, so_far in hits if len(so_far) < config.min_hits]
        return replace(self, candidates=(*waiting, *tentative)), begun
