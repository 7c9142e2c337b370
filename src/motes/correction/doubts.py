"""Doubtful frames of a track, and why: another's, cuts, jumps, leaps of size, dissent, losses."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import NamedTuple

import numpy as np
from msgspec.structs import replace

from motes.core.geometry import Ellipse
from motes.core.track import Status, Track
from motes.core.types import Flags, Floats
from motes.correction.coordinates import Coordinates
from motes.correction.gains import ranked
from motes.correction.join import Stretch, both, shared_variance
from motes.correction.passes import Course
from motes.correction.smoothing import local_variance

PLANE_GATE = 13.82
"""The 99.9 % quantile of the chi-square distribution with 2 degrees of freedom."""
LEAST_GAIN = 0.5
"""Frames that a correction is expected to make right, at least: others are not worth a look."""
DOUBTFUL = [each for each in Status if each not in (Status.TRACKING, Status.ABSENT)]
"""States in which a frame is doubtful."""
ANOTHER = "perhaps another"
"""Why a frame comes before all others: a neighbor who looks alike may be followed in its place."""
EITHER = 0.5
"""Confidence after a jump: the place before it or the one after it is right."""


class Doubt(NamedTuple):
    """A doubtful frame."""

    frame: int
    """Index of the frame."""
    gain: float
    """Number of frames that its correction is expected to make right."""
    reasons: tuple[str, ...]
    """Why the frame is in doubt."""


def doubts(
    tracks: Sequence[Track], keyframes: Iterable[int], count: int = 20, cuts: Iterable[int] = ()
) -> list[Doubt]:
    """Return doubtful frames of a track, each to be corrected after those before it.

    The gain of a correction is the expected number of frames whose boxes it makes right (IoU of 0.7
    or more), from the covariances, the confidences, and jumps. A frame is doubtful for a reason;
    its distance from a keyframe alone is none. Frames in which perhaps another is followed come
    first; those with a gain below `LEAST_GAIN` are left out.

    Parameters
    ----------
    tracks
        The track of each frame, in order; its covariance may be unknown, NaN.
    keyframes
        The frames that the user has marked.
    count
        Number of frames; there are fewer if others have no gain.
    cuts
        The frames with which the film is cut to another picture: what is followed from there on may
        be anything.

    Raises
    ------
    ConfigError
        If they are no tracks, as rows of `read_track`.
    """
    only = Course.of(tracks)
    outlier = only.outlier
    frames = [track.frame for track in tracks]
    keys, cut = np.isin(frames, [*keyframes]), np.isin(frames, [*cuts])
    tracking = only.where(Status.TRACKING, Status.INTERPOLATED)
    absent = only.where(Status.ABSENT)
    jumps, leaps = _jumps(only, tracking)
    confidence = np.where(outlier, np.minimum(only.confidence, EITHER), only.confidence)
    for start in np.flatnonzero((jumps & ~outlier | cut) & ~keys):
        following = np.flatnonzero(keys[start:])
        stop = start + (int(following[0]) if len(following) else len(keys))
        confidence[start:stop] = np.minimum(confidence[start:stop], EITHER)
    named = {
        ANOTHER: np.array([track.belief < EITHER for track in tracks], bool),
        "a tracker was elsewhere": outlier,
        "cut": cut,
        "jump": jumps,
        "leap of the size": leaps,
        **{str(each): only.where(each) for each in DOUBTFUL},
        "low confidence": only.confidence < EITHER,
    }
    ellipses = np.where(absent[:, None], np.nan, only.ellipses)
    variances = np.nan_to_num(np.maximum(only.variances - _drifted(only, keys), 0))
    doubtful = np.logical_or.reduce([*named.values()])
    asked = named[ANOTHER], doubtful
    found = ranked(ellipses, variances, np.nan_to_num(confidence), keys, count, asked, LEAST_GAIN)
    return [
        Doubt(tracks[place].frame, gain, tuple(why for why, holds in named.items() if holds[place]))
        for place, gain in found
    ]


def compare(tracks: Sequence[Track], backward: Sequence[Track]) -> list[Track]:
    """Return tracks judged by a backward pass over the same frames, from the last of them.

    The confidence is at most the probability that the forward pass follows the target. Rows that
    the backward pass contradicts are outliers.
    """
    forward, back = Course.of(tracks), Course.of(backward)
    begin, end = tracks[0].ellipse, tracks[-1].ellipse
    absent = np.zeros(len(tracks), bool)
    stretch = Stretch(tracks[0].frame, tracks[-1].frame, begin, end)
    follows = both(stretch, forward, back, absent, same_end=True)
    unlike = forward.where(Status.TRACKING) & ~follows.used[0]
    share = np.where(follows.used[0], follows.probability, 1 - follows.probability)
    return [
        replace(track, confidence=min(track.confidence, float(share[i])), outlier=bool(unlike[i]))
        for i, track in enumerate(tracks)
    ]


def _jumps(only: Course, tracking: Flags) -> tuple[Flags, Flags]:
    """Return in which frames the place, and the size, changes by more than the motion explains."""
    where = np.flatnonzero(tracking)
    jumps, leaps = np.zeros(len(tracking), bool), np.zeros(len(tracking), bool)
    if len(where) < 3:
        return jumps, leaps
    space = Coordinates.of([Ellipse(*row) for row in only.ellipses[where].tolist()], only.ellipses)
    values = space.values(only.ellipses)[where, :4]
    steps = np.diff(values, axis=0) ** 2 / local_variance(values, where)
    jumps[where[1:]] = steps[:, :2].sum(axis=1) > PLANE_GATE
    leaps[where[1:]] = steps[:, 2:].sum(axis=1) > PLANE_GATE
    return jumps, leaps


def _drifted(only: Course, keys: Flags) -> Floats:
    """Return the part (n, 5) of variances that grows with the distance from a keyframe alone."""
    rows = np.logical_and.reduce(np.isfinite(only.ellipses), axis=1)
    ellipses = np.where(rows[:, None], only.ellipses, [0.0, 0.0, 1.0, 1.0, 0.0])
    sides = 4 * ellipses[:, 2] * ellipses[:, 3]
    drift = 2 * shared_variance(len(keys), np.flatnonzero(keys).tolist())
    units = np.stack(
        [sides, sides, ellipses[:, 2] ** 2, ellipses[:, 3] ** 2, np.ones_like(sides)], 1
    )
    out: Floats = drift * units
    return out
