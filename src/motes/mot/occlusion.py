"""Which objects may occlude each other."""

from __future__ import annotations

import numpy as np

from motes.core.types import Floats
from motes.mot.boxes import search_areas
from motes.mot.pairs import Integers, meeting


def occlusion_candidates(boxes: Floats) -> tuple[Integers, Integers]:
    """Return which objects, in boxes (n, 4), are so near that one may occlude the other.

    Zhao and Pei, equations 18 and 19: the squared distance of their centers is less than
    A² + B², where A and B are half the sum of their widths and of their heights. The paper compares
    it with the root of that. No object is a candidate for itself.

    Returns
    -------
    i, j
        (k,) each, indices of both, each pair in both orders, sorted.
    """
    centers, sizes = boxes[:, :2] + boxes[:, 2:] / 2, boxes[:, 2:]
    # The root of A² + B² is at most half the sum of the diagonals.
    around = search_areas(centers, np.hypot(sizes[:, 0], sizes[:, 1]) / 2)
    i, j = meeting(around, around)
    offsets, reach = centers[i] - centers[j], (sizes[i] + sizes[j]) / 2
    near = ((offsets**2).sum(axis=1) < (reach**2).sum(axis=1)) & (i != j)
    return i[near], j[near]
