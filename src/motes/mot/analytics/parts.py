"""Which objects are parts of one vehicle, as a dark car whose windows look like the road."""

from __future__ import annotations

import itertools
import math
from collections.abc import Mapping, Sequence

import numpy as np

from motes.core.geometry import Box
from motes.core.track import Track
from motes.mot.analytics.trajectory import Trajectory
from motes.mot.overlaps import as_rows

KEPT, FEW = 100, 3
"""How many of the latest shapes are kept at a line, and the least number that tells a usual one."""
USUAL = 0.8
"""The usual shape is this quantile of all: parts are narrower than what is whole."""
LIKE = 1.4
"""Two shapes are alike up to this ratio."""
GAP = 0.2
"""Parts are at most this share of the whole's length apart, and their ways differ by at most this
share."""


def usual_of(shapes: Sequence[float]) -> float | None:
    """Return how many times as wide as high objects usually are, of those that have passed."""
    return float(np.quantile(shapes, USUAL)) if len(shapes) >= FEW else None


def whole_of(
    each: Track, tracks: Sequence[Track], paths: Mapping[int, Trajectory], usual: float | None
) -> tuple[list[int], float]:
    """Return the identities of the parts of the vehicle that an object is of, and its shape.

    Parts are in a row along their way, nearly touch and move alike, and all together they have the
    usual shape, rather than the object alone. `tracks` are all that are seen in this frame, `paths`
    theirs by identity, and `usual` the usual width by height there. Where that is unknown, the
    object is whole.
    """
    path, shape = paths[each.identity], each.box.width / each.box.height
    if usual is None:
        return [each.identity], shape
    along = int(np.ptp([place for _, place in path.feet], axis=0).argmax())
    row = [
        other for other in tracks
        if _level(each.box, other.box, 1 - along) and _together(path, paths[other.identity])
    ]  # fmt: skip
    row.sort(key=lambda other: other.box[along])
    boxes = as_rows(other.box for other in row)
    ends, this = boxes[:, :2] + boxes[:, 2:], row.index(each)
    least, found = min(abs(math.log(shape / usual)), math.log(LIKE)), [each]
    for first, last in itertools.product(range(this + 1), range(this + 1, len(row) + 1)):
        width, height = ends[first:last].max(axis=0) - boxes[first:last, :2].min(axis=0)
        gaps = boxes[first + 1 : last, along] - ends[first : last - 1, along]
        touch = np.abs(gaps).max(initial=0) <= GAP * (width, height)[along]
        error = abs(math.log(width / height / usual))
        if touch and error < least:
            least, shape, found = error, width / height, row[first:last]
    return [other.identity for other in found], float(shape)


def _level(one: Box, other: Box, axis: int) -> bool:
    """Return whether two boxes share half of the larger one's extent along an axis."""
    ends = one[axis] + one[axis + 2], other[axis] + other[axis + 2]
    shared = min(ends) - max(one[axis], other[axis])
    return shared >= max(one[axis + 2], other[axis + 2]) / 2


def _together(one: Trajectory, other: Trajectory) -> bool:
    """Return whether two have gone the same way in the last half second, both of them seen."""
    ours, theirs = dict(one.feet), dict(other.feet)
    both = sorted(ours.keys() & theirs.keys())
    if len(both) < 2:
        return one is other
    places = np.array([(ours[at], theirs[at]) for at in both])
    went = places[-1] - places[0]
    return bool(np.linalg.norm(went[1] - went[0]) <= GAP * np.linalg.norm(went[0]))
