"""Objects of a dataset that count neither for nor against a tracker (MOTChallenge)."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from motes.core.errors import MissingDependencyError
from motes.core.geometry import iou
from motes.evaluation.datasets.mot_files import UNKNOWN, Rows

Floats = NDArray[np.float64]
Integers = NDArray[np.int64]


MATCHED = 0.5
"""An overlap (IoU) from which on a box can be that of an object, for all but HOTA."""


_TINY = float(np.finfo(float).eps)


def assigned_pairs(worth: Floats) -> tuple[Integers, Integers]:
    """Return rows and columns of the one-to-one assignment that is worth most."""
    i, j = solver()(worth, maximize=True)
    return i, j


def solver() -> Callable[..., tuple[Integers, Integers]]:
    """Return what assigns rows to columns; raise a MissingDependencyError without scipy."""
    try:
        from scipy.optimize import linear_sum_assignment
    except ImportError:
        raise MissingDependencyError(
            "Measuring identities needs scipy; install it: pip install 'motes[report]'."
        ) from None
    solve: Callable[..., tuple[Integers, Integers]] = linear_sum_assignment
    return solve


PEDESTRIAN = 1


DISTRACTORS = (2, 7, 8, 12)
"""Classes that may be taken for a pedestrian: on a vehicle, static, distractor, reflection."""


def counted(truth: Rows, results: Rows, distractors: tuple[int, ...]) -> tuple[Rows, Rows]:
    """Return what is compared of truth and results, as the MOTChallenge does.

    Of the truth, rows whose flag is not 0, if they are pedestrians or the truth has no classes. Of
    the results, all but those that, in the best assignment to all rows of the truth, overlap a
    distractor by `MATCHED` or more. Milan et al., MOT16, 2016, section 5.1.1.
    """
    off = np.zeros(len(results.frames), bool)
    if np.isin(truth.classes, distractors).any():
        for frame in np.unique(truth.frames):
            there, said = truth.at(frame), results.at(frame)
            overlaps = iou(truth.boxes[there, None], results.boxes[said])
            overlaps[overlaps < MATCHED - _TINY] = 0
            i, j = assigned_pairs(overlaps)
            off[said][j] = (overlaps[i, j] > 0) & np.isin(truth.classes[there][i], distractors)
    meant = np.isin(truth.classes, (UNKNOWN, PEDESTRIAN)) & (truth.scores.astype(np.int64) != 0)
    return truth.where(meant), results.where(~off)
