"""How well a track fits the truth."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]

THRESHOLDS = np.linspace(0, 1, 21)


def success_auc(overlaps: Floats) -> float:
    """Return the area under the success curve, as the mean over 21 thresholds from 0 to 1.

    The curve is the share of frames whose overlap (IoU, (frames,)) exceeds a threshold. Wu, Lim and
    Yang, Online object tracking: a benchmark, CVPR 2013.
    """
    return float((overlaps[:, None] > THRESHOLDS).mean())


def detection_f1(said: NDArray[np.bool_], true: NDArray[np.bool_]) -> float:
    """Return F1 of a yes-or-no statement per frame; 1 where nothing was said and nothing true."""
    together = np.count_nonzero(said) + np.count_nonzero(true)
    return 2 * np.count_nonzero(said & true) / together if together else 1.0


def calibration_error(confidence: Floats, correct: NDArray[np.bool_], weights: Floats) -> float:
    """Return the expected calibration error (ECE).

    The mean, over ten equally wide bins of confidence and weighted by their share of the frames, of
    the distance between the mean confidence and the share of correct frames. `weights` (frames,)
    let each sequence count the same however long it is.
    """
    which = np.minimum((confidence * 10).astype(int), 9)
    gap = np.bincount(which, weights * (confidence - correct))
    return float(np.abs(gap).sum() / weights.sum())
