"""What becomes an object: what is detected in several frames in a row, and surely enough."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TypeAlias

import numpy as np

from motes.core.detection import Detection
from motes.core.geometry import Box
from motes.mot.assignment import assign_pairs
from motes.mot.association import as_rows
from motes.mot.overlaps import overlapping

Tentative: TypeAlias = list[tuple[float, Box]]
"""Times and boxes of detections that may be one object."""

SCORES = 1000
"""How sure detections are is judged by so many of the latest, or all of a frame that has more."""


class TrackInitiation:
    """Keeps what may become an object, from frame to frame.

    Parameters
    ----------
    overlap
        Least intersection over union of a detection with the one before.
    confirm
        How many frames in a row make an object.
    doubt
        This share of all detections, the least sure ones, begins none.
    """

    def __init__(self, overlap: float, confirm: int, doubt: float) -> None:
        self._overlap, self._confirm, self._doubt = overlap, confirm, doubt
        self._candidates: list[Tentative] = []
        self._scores: list[float] = []

    def note(self, found: Sequence[Detection]) -> None:
        """Learn how sure detections are: all those of a frame."""
        scores = [*self._scores, *(each.score for each in found)]
        self._scores = scores[-max(SCORES, len(found)) :]

    def update(self, time: float, free: Sequence[Detection]) -> list[Tentative | None]:
        """Return the sightings of what each detection of no object may be, or None if in doubt.

        Those with `confirm` sightings are objects from now on, and are forgotten here.
        """
        before = self._candidates
        boxes = as_rows(each.box for each in free)
        latest = as_rows(candidate[-1][1] for candidate in before)
        i, j, overlaps = overlapping(latest, boxes, self._overlap)
        same = assign_pairs(i, j, 1 - overlaps, (len(before), len(free)))
        history = {j: before[i] for i, j in same}
        sure = np.quantile(self._scores, self._doubt) if free else 0.0
        out: list[Tentative | None] = [
            None if each.score < sure else [*history.get(j, []), (time, each.box)]
            for j, each in enumerate(free)
        ]
        self._candidates = [
            candidate
            for candidate in out
            if candidate is not None and len(candidate) < self._confirm
        ]
        return out
