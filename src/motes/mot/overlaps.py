"""Boxes as arrays, and overlaps of many: lists of the pairs that overlap, not a matrix of all.

`overlapping_pairs`, `covered_pairs` and `nested_pairs` return indices of the first and of the
second boxes, sorted by the first, then by the second, and a value for each pair: (k,) each.
"""

from __future__ import annotations

from collections.abc import Iterable
from itertools import chain
from typing import TypeAlias

import numpy as np

from motes.core.frame import Frame
from motes.core.geometry import Box, intersection, iou
from motes.core.types import Flags, Floats
from motes.mot.pairs import Integers, meeting

MARGIN = 1.0
"""Pixels that are added to a search area, so that rounding excludes nothing."""


def as_rows(boxes: Iterable[Box]) -> Floats:
    """Return boxes as (n, 4)."""
    return np.fromiter(chain.from_iterable(boxes), np.float64).reshape(-1, 4)


def inscribed(boxes: Floats) -> Floats:
    """Return the upright ellipses in boxes (n, 4), as `Ellipse.from_box` does: (n, 5)."""
    centers = boxes[:, :2] + (boxes[:, 2:] - 1) / 2
    return np.hstack([centers, boxes[:, 2:] / 2, np.zeros((len(boxes), 1))])


def search_areas(centers: Floats, radii: Floats) -> Floats:
    """Return squares (n, 4) that hold circles around centers (n, 2) with radii (n,)."""
    half = radii + MARGIN
    sides = 2 * half[:, None]
    return np.hstack([centers - half[:, None], sides, sides])


def areas(boxes: Floats) -> Floats:
    """Return the areas of boxes, shape (..., 4)."""
    return boxes[..., 2] * boxes[..., 3]


def intersection_over_first(first: Floats, second: Floats) -> Floats:
    """Return the share of each first box that the second one covers, shapes (..., 4) broadcast."""
    return intersection(first, second) / areas(first)


Overlaps: TypeAlias = tuple[Integers, Integers, Floats]

CONTAINED = 0.7
"""A box lies in another one if that one covers more than this share of it."""
MERGED = 1.4
"""A detection that contains several objects is more than this many times as large as each."""
FILLED = 0.6
"""Objects in a detection that contains them have at least this share of its area together."""
BLOCK = 500
"""Number of boxes that are compared at a time, to limit memory where most of them overlap."""


def overlapping_pairs(first: Floats, second: Floats, least: float) -> Overlaps:
    """Return the pairs of boxes (n, 4) and (m, 4) with a least intersection over union, and it.

    If the least one is 0, these are all n m pairs.
    """
    if least > 0:
        i, j = meeting(first, second)
    else:
        i, j = np.indices((len(first), len(second))).reshape(2, -1)
    return _where(i, j, overlaps := iou(first[i], second[j]), overlaps >= least)


def covered_pairs(first: Floats, second: Floats, share: float) -> Overlaps:
    """Return the pairs where the second box covers more than a share of the first, and how much."""
    i, j = meeting(first, second)
    return _where(i, j, shares := intersection_over_first(first[i], second[j]), shares > share)


def nested_pairs(first: Floats, second: Floats, share: float) -> Overlaps:
    """Return the pairs where one box covers more than a share of the other, and how much."""
    i, j = meeting(first, second)
    first, second = first[i], second[j]
    shares = intersection(first, second) / np.minimum(areas(first), areas(second))
    return _where(i, j, shares, shares > share)


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


def best_partners(i: Integers, j: Integers, values: Floats) -> dict[int, int]:
    """Return for each i the j with the largest value; of equal values, the smallest j."""
    order = np.lexsort((j, -values, i))
    rows, first = np.unique(i[order], return_index=True)
    return dict(zip(rows.tolist(), j[order][first].tolist(), strict=True))


def without_duplicates(boxes: Floats, share: float) -> list[int]:
    """Return which boxes (n, 4) stay if each one removes its duplicates among those after it.

    Two boxes are duplicates if one covers more than a share of the other.
    """
    kept: list[int] = []
    for start in range(0, len(boxes), BLOCK):
        block = boxes[start : start + BLOCK]
        dropped = set(nested_pairs(block, boxes[kept], share)[0].tolist())
        rest = np.array([n for n in range(len(block)) if n not in dropped], np.int64)
        i, j, _ = nested_pairs(block[rest], block[rest], share)
        for one, before in zip(rest[i[j < i]].tolist(), rest[j[j < i]].tolist(), strict=True):
            if before not in dropped:
                dropped.add(one)
        kept += [start + n for n in rest.tolist() if n not in dropped]
    return kept


def merged_blobs(places: Floats, boxes: Floats) -> dict[int, list[int]]:
    """Return which boxes (m, 4) hold several objects, in places (n, 4), each with its objects.

    In such a box lie two objects or more, which fill it, and it is more than `MERGED` times as
    large as each; else they may be parts of one object. An object in several such boxes belongs to
    the one that covers most of it.
    """
    i, j, shares = covered_pairs(places, boxes, CONTAINED)
    sizes = np.zeros(len(boxes))
    np.maximum.at(sizes, j, areas(places[i]))
    several = np.bincount(j, minlength=len(boxes)) > 1
    several &= areas(boxes) > MERGED * sizes
    out: dict[int, list[int]] = {box: [] for box in np.flatnonzero(several).tolist()}
    for place, box in best_partners(*_where(i, j, shares, several[j])).items():
        out[box].append(place)
    filled = FILLED * areas(boxes)
    return {box: held for box, held in out.items() if areas(places[held]).sum() >= filled[box]}


def grouped(i: Integers, j: Integers) -> dict[int, Integers]:
    """Return for each i all its j; i is sorted."""
    found, starts = np.unique(i, return_index=True)
    return dict(zip(found.tolist(), np.split(j, starts[1:]), strict=True)) if len(i) else {}


def _where(i: Integers, j: Integers, values: Floats, chosen: Flags) -> Overlaps:
    """Return some of the pairs."""
    return i[chosen], j[chosen], values[chosen]


def inside(boxes: Floats, frame: Frame) -> Flags:
    """Return which boxes (n, 4) the edge of the picture does not cut, (n,).

    Detectors end boxes at the edge, so one that touches it may be cut.
    """
    ends = boxes[:, :2] + boxes[:, 2:]
    out: Flags = np.all((boxes[:, :2] > 0) & (ends < (frame.width, frame.height)), axis=1)
    return out
