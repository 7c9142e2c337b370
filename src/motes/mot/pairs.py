"""Which boxes share an area, without a comparison of all pairs.

All boxes are cut into horizontal strips of their mean height: on average at most three parts for
each box, whatever the sizes. If two boxes share an area in a strip, the left edge of one lies
within the other. In a sorted list of left edges, these are neighbors.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from motes.core.geometry import intersection
from motes.core.types import Floats

Integers = NDArray[np.int64]

FEW = 2**11
"""Largest number of pairs for which a comparison of all takes less time than the sweep."""


def meeting(first: Floats, second: Floats) -> tuple[Integers, Integers]:
    """Return the pairs of boxes (n, 4) and (m, 4) that share an area.

    Time and memory grow with the number of pairs that overlap from left to right in a strip, not
    with n m.

    Returns
    -------
    i, j
        (k,) each, indices into the first and the second boxes, sorted by i, then by j.
    """
    if not (len(first) and len(second)):  # as where nobody is hidden
        return np.empty(0, np.int64), np.empty(0, np.int64)
    if len(first) * len(second) <= FEW:
        i, j = np.nonzero(intersection(first[:, None], second) > 0)
        return i, j
    i, j = candidates(first, second)
    met = intersection(first[i], second[j]) > 0
    i, j = i[met], j[met]
    order = np.lexsort((j, i))
    return i[order], j[order]


class _Parts(NamedTuple):
    """Parts of boxes in strips, sorted by strip and left edge."""

    box: Integers
    top: Integers
    """(p,), index of the box, and the first strip that it is in."""
    strip: Integers
    """(p,), the part's strip."""
    begin: Integers
    end: Integers
    """(p,), of the left and right edges: keys that sort by strip, then from left to right."""


def candidates(first: Floats, second: Floats) -> tuple[Integers, Integers]:
    """Return the pairs of `meeting`, each once, and others that overlap only from left to right."""
    both = np.concatenate([first, second])
    if not both[:, 3].any():
        return np.zeros(0, np.int64), np.zeros(0, np.int64)
    height = float(both[:, 3].mean())
    edges = np.unique([both[:, 0], both[:, 0] + both[:, 2]])
    one, other = _parts(first, height, edges), _parts(second, height, edges)
    i, j = _between(other.begin, one.begin, one.end)
    later, earlier = _between(one.begin, other.begin + 1, other.end)
    i, j = np.concatenate([i, earlier]), np.concatenate([j, later])
    # Pairs that have several strips in common count in the first of these.
    once = one.strip[i] == np.maximum(one.top[i], other.top[j])
    return one.box[i[once]], other.box[j[once]]


def _parts(boxes: Floats, height: float, edges: Floats) -> _Parts:
    """Return the parts of boxes (n, 4) in strips; `edges` are all left and right edges, sorted."""
    tops = np.floor(boxes[:, 1] / height).astype(np.int64)
    counts = np.floor((boxes[:, 1] + boxes[:, 3]) / height).astype(np.int64) - tops + 1
    box, nth = _ranges(counts)
    strip = tops[box] + nth
    left, right = boxes[box, 0], boxes[box, 0] + boxes[box, 2]
    begin, end = (strip * len(edges) + np.searchsorted(edges, x) for x in (left, right))
    order = np.argsort(begin, kind="stable")
    return _Parts(*(each[order] for each in (box, tops[box], strip, begin, end)))


def _between(keys: Integers, low: Integers, high: Integers) -> tuple[Integers, Integers]:
    """Return the indices of intervals, low <= key < high, and of sorted keys in them, as pairs."""
    starts = np.searchsorted(keys, low)
    interval, nth = _ranges(np.maximum(np.searchsorted(keys, high) - starts, 0))
    return interval, starts[interval] + nth


def _ranges(counts: Integers) -> tuple[Integers, Integers]:
    """Return for [2, 0, 3] the indices [0, 0, 2, 2, 2] and their numbers [0, 1, 0, 1, 2]."""
    index = np.repeat(np.arange(len(counts)), counts)
    before = np.cumsum(counts) - counts
    return index, np.arange(len(index)) - before[index]
