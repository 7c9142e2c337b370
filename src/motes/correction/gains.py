"""The frames whose correction is expected to make the most frames right.

A frame is wrong if its box overlaps the target too little. The probability of that follows from the
variances and from the confidence. A new keyframe at t also makes its neighbors right, the more, the
nearer they are: errors between two keyframes are correlated as those of a Brownian bridge. The gain
of t is the sum over all frames of how much less likely they are to be wrong.
"""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from motes.core.types import Flags, Floats
from motes.correction.coordinates import overlap_probability

RIGHT = 0.7
"""Overlap (IoU) from which a box needs no correction."""
CANDIDATES = 1000
"""Frames between two keyframes that are compared at most; in longer stretches, every n-th one."""


class Ranked(NamedTuple):
    """A doubtful frame."""

    place: int
    """The place of the frame in the arrays."""
    gain: float
    """Number of frames that its correction is expected to make right."""


def wrong(ellipses: Floats, variances: Floats, confidence: Floats) -> Floats:
    """Return the probability (n,) that each box is wrong; NaN rows have none: 0.

    The path and its variances are (n, 5); the confidence (n,) is the probability that the target is
    followed at all.
    """
    out = 1 - confidence * overlap_probability(ellipses, variances, RIGHT)
    return np.nan_to_num(out, nan=0.0)


def ranked(
    ellipses: Floats,
    variances: Floats,
    confidence: Floats,
    keys: Flags,
    count: int,
    asked: Sequence[Flags] = (),
    least: float = 0.0,
) -> list[Ranked]:
    """Return doubtful frames, each to be corrected after those before it, the largest gain first.

    The arrays are as in `wrong`, and `keys` (n,) is which frames are keyframes. There are fewer
    than `count` if no other frame has a gain above `least`. `asked` has the frames (n,) that may be
    returned: those of the first, then those of the next; by default all of them.
    """
    variances, confidence, keys = variances.copy(), confidence.copy(), keys.copy()
    found: list[Ranked] = []
    for group in asked or [np.ones(len(keys), bool)]:
        best: dict[tuple[int, int], Ranked] = {}
        while len(found) < count and (spans := _spans(keys)):
            for span in set(spans) - set(best):
                part = slice(*span)
                values = ellipses[part], variances[part], confidence[part]
                gains = _gains(*values, group[part], keys[part])
                place = int(gains.argmax()) if len(gains) else 0
                best[span] = Ranked(span[0] + place, float(gains[place]))
            span = max(spans, key=lambda each: best[each].gain)
            top = best[span]
            if top.gain <= least or keys[top.place]:
                break
            found.append(top)
            part = slice(*span)
            places, mark = np.arange(span[1] - span[0]), np.array([top.place - span[0]])
            left = 1 - _correlation(places, mark, keys[part])[:, 0] ** 2
            variances[part] *= left[:, None]
            confidence[part] = 1 - (1 - confidence[part]) * left
            keys[top.place] = True
            del best[span]  # with a keyframe at its end, it is another one
    return found


def _spans(keys: Flags) -> list[tuple[int, int]]:
    """Return the stretches between neighboring keyframes, which both belong to them."""
    ends = [0, *np.flatnonzero(keys).tolist(), len(keys) - 1]
    return [(a, b + 1) for a, b in itertools.pairwise(ends) if b > a]


def _gains(
    ellipses: Floats, variances: Floats, confidence: Floats, asked: Flags, keys: Flags
) -> Floats:
    """Return the gain (n,) of each frame of a stretch, of which only the ends may be keyframes.

    Only frames that are asked for have one; of many, every n-th. In a long stretch, every n-th
    frame counts for its neighbors.
    """
    out = np.zeros(len(ellipses))
    step = -(-len(ellipses) // CANDIDATES)
    places = np.arange(0, len(ellipses), step)
    marks = np.flatnonzero(asked & ~np.isnan(ellipses[:, 0]))  # not where the user has said absent
    marks = marks[:: max(1, -(-len(marks) // CANDIDATES))]
    if not len(marks):
        return out
    ellipses, variances, confidence = (
        values[places] for values in (ellipses, variances, confidence)
    )
    left = 1 - _correlation(places, marks, keys) ** 2
    before = wrong(ellipses, variances, confidence)
    after = np.stack(
        [
            wrong(ellipses, variances * share[:, None], 1 - (1 - confidence) * share)
            for share in left.T
        ],
        axis=1,
    )
    out[marks] = step * np.maximum(before[:, None] - after, 0).sum(axis=0)
    return out


def _correlation(places: NDArray[np.int64], marks: NDArray[np.int64], keys: Flags) -> Floats:
    """Return the correlation (n, m) of the errors at places and at marks.

    They are a Brownian bridge between two keyframes, and a Brownian motion from one alone.
    """
    end = max(int(places[-1]), int(marks[-1]))
    s, t = places[:, None].astype(np.float64), marks[None, :].astype(np.float64)
    near, far = np.minimum(s, t), np.maximum(s, t)
    if keys[0] and keys[-1]:
        square = near * (end - far), far * (end - near)
    elif keys[0]:
        square = near, far
    elif keys[-1]:
        square = end - far, end - near
    else:
        square = np.ones_like(near), np.ones_like(far)
    ratio = np.divide(
        *square, out=np.zeros(np.broadcast_shapes(s.shape, t.shape)), where=square[1] > 0
    )
    ratio[(s == t) & (square[1] > 0)] = 1.0
    out: Floats = np.sqrt(ratio)
    return out
