"""Distractors of the MOTChallenge: objects that count neither for nor against a tracker."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from motes.core import Floats, iou
from motes_lab.datasets.mot_rows import UNKNOWN, MotRows

Integers = NDArray[np.int64]


MATCH_IOU = 0.5
"""Smallest overlap (IoU) at which a box may match an object, in all metrics except HOTA."""


EPSILON = float(np.finfo(float).eps)


def assigned_pairs(values: Floats) -> tuple[Integers, Integers]:
    """Return rows and columns of the one-to-one assignment with the largest sum of values."""
    from scipy.optimize import linear_sum_assignment  # takes half a second to import

    i, j = linear_sum_assignment(values, maximize=True)
    return i, j


PEDESTRIAN = 1


DISTRACTORS = (2, 7, 8, 12)
"""Classes that may be mistaken for a pedestrian: on a vehicle, static, distractor, reflection."""


def evaluated_rows(
    truth: MotRows, results: MotRows, distractors: tuple[int, ...]
) -> tuple[MotRows, MotRows]:
    """Return the rows of truth and results that are compared, by the rules of the MOTChallenge.

    Rows of the truth are compared if their flag is not 0 and they are pedestrians, or the truth has
    no classes. Rows of the results are compared unless the best assignment to all rows of the truth
    gives them a distractor with an overlap of `MATCH_IOU` or more. Milan et al., MOT16, 2016,
    section 5.1.1.
    """
    ignored = np.zeros(len(results.frames), bool)
    if np.isin(truth.classes, distractors).any():
        for frame in np.unique(truth.frames):
            true_rows, rows = truth.at(frame), results.at(frame)
            overlaps = iou(truth.boxes[true_rows, None], results.boxes[rows])
            overlaps[overlaps < MATCH_IOU - EPSILON] = 0
            i, j = assigned_pairs(overlaps)
            is_distractor = np.isin(truth.classes[true_rows][i], distractors)
            ignored[rows][j] = (overlaps[i, j] > 0) & is_distractor
    evaluated = np.isin(truth.classes, (UNKNOWN, PEDESTRIAN))
    evaluated &= truth.scores.astype(np.int64) != 0
    return truth.where(evaluated), results.where(~ignored)
