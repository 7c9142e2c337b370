"""How many crossings of a line are counted."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from motes.mot.assignment import assign

WITHIN = 10
"""Frames by which a counted crossing may be early or late."""


class Compared(NamedTuple):
    """Frames of true crossings that were counted and missed, and of false ones, each sorted."""

    counted: list[int]
    missed: list[int]
    false: list[int]

    def __add__(self, other: tuple[list[int], ...]) -> Compared:  # type: ignore[override]
        return Compared(*(sorted(a + b) for a, b in zip(self, other, strict=True)))


def compare_crossings(
    truth: Sequence[int], counted: Sequence[int], within: float = WITHIN
) -> Compared:
    """Compare the frames of crossings of a line in one direction.

    A true crossing is counted if a counted one is within so many frames, one to one, as many as can
    be.
    """
    off = np.abs(np.subtract.outer(np.array(truth, float), np.array(counted, float)))
    pairs = assign(np.where(off <= within, off, np.inf)) if off.size else []
    found, used = {i for i, _ in pairs}, {j for _, j in pairs}
    return Compared(
        sorted(each for i, each in enumerate(truth) if i in found),
        sorted(each for i, each in enumerate(truth) if i not in found),
        sorted(each for j, each in enumerate(counted) if j not in used),
    )
