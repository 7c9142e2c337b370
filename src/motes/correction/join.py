"""A stretch of film between keyframes: its passes become one track."""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from motes.core.geometry import Box, Ellipse, as_ellipse, iou
from motes.core.track import Status, Track
from motes.core.types import Flags, Floats
from motes.correction.coordinates import Coordinates, overlap_probability
from motes.correction.keyframes import Keyframes, Region
from motes.correction.passes import Course
from motes.correction.smoothing import Drift, fit_motion, outliers, smoothed
from motes.correction.support import Support, support

CENTER_DRIFT, CENTER_MEMORY = 0.06, 10.0
"""Standard deviation of the offset of a pass's center from the target's, in mean sides, and its
memory in frames: measured with `default` on 24 sequences, see docs/correct.md."""
SIZE_DRIFT, SIZE_MEMORY = 0.18, 40.0
"""The same for the logarithms of the half-axes, and for the angle in radians."""
DRIFT = Drift(
    np.array([CENTER_DRIFT] * 2 + [SIZE_DRIFT] * 3),
    np.array([CENTER_MEMORY] * 2 + [SIZE_MEMORY] * 3),
)
"""The drift in the coordinates of `Coordinates`."""
SHARED_MOTION = 10.0
"""Motion that both passes see counts as this many times as likely as the same drift of both. From
10 to 1000, the results on these sequences hardly change."""
HALF = 0.5
"""Overlap from which two boxes are of the same target."""
GATE = 18.47
"""The 99.9 % quantile of the chi-square distribution with 4 degrees of freedom."""


class Stretch(NamedTuple):
    """Frames in a row, and the keyframes at their ends."""

    first: int
    last: int
    """The first and the last frame."""
    begin: Region | None
    end: Region | None
    """The keyframes there; one of them is None where the film begins or ends without one."""
    absent: frozenset[int] = frozenset()
    """Frames in which the target is marked as absent."""

    @classmethod
    def between(cls, frames: range, keys: Keyframes) -> list[Stretch]:
        """Return the stretches of frames between neighboring keyframes, and before and after them.

        Neighboring stretches share a keyframe. Each has one at an end at least.
        """
        marked = {frame: region for frame, region in keys.items() if region is not None}
        ends = sorted({frames.start, *marked, frames.stop - 1})
        if len(ends) == 1:
            return [cls(ends[0], ends[0], marked[ends[0]], None)]
        found = []
        for first, last in itertools.pairwise(ends):
            absent = frozenset(t for t in range(first, last + 1) if t in keys and keys[t] is None)
            found.append(cls(first, last, marked.get(first), marked.get(last), absent))
        return found

    @property
    def keys(self) -> dict[int, Region]:
        """The keyframes, by their place in the stretch."""
        ends = {0: self.begin, self.last - self.first: self.end}
        return {i: key for i, key in ends.items() if key is not None}

    def begun(self, last: int) -> Stretch:
        """Return the part up to a frame, the last one of a forward pass that was interrupted."""
        absent = frozenset(frame for frame in self.absent if frame <= last)
        return self._replace(last=last, end=None, absent=absent)

    def joined(
        self, times: Sequence[float], forward: Course | None, backward: Course | None
    ) -> list[Track]:
        """Return the track of each frame, from passes as for `course`.

        `times` has those of all frames of the film.
        """
        nan = math.nan
        empty = [
            Track(i, times[i], Ellipse(0, 0, 1, 1), np.eye(5), nan, Status.LOST, nan, nan)
            for i in range(self.first, self.last + 1)
        ]
        return self.course(forward, backward).tracks(empty)

    def course(self, forward: Course | None, backward: Course | None) -> Course:
        """Return where the target is in its frames.

        The passes are over all of these frames, from the first and from the last keyframe; None
        without such a keyframe. There is one at least.
        """
        passes = [each for each in (forward, backward) if each is not None]
        absent = np.zeros(len(passes[0].ellipses), bool)
        absent[[frame - self.first for frame in self.absent]] = True
        if forward is not None and backward is not None:
            follows = both(self, forward, backward, absent)
        else:
            follows = tracked(passes[0], absent)
        starts = [0] * (forward is not None) + [-1] * (backward is not None)
        follows.used[np.arange(len(starts)), starts] = True  # each on its own keyframe
        return fuse(passes, follows, self.keys, starts, absent)


def tracked(only: Course, absent: Flags) -> Support:
    """Return the support of one pass: what it has tracked, except for jumps away and back."""
    used = only.where(Status.TRACKING) & ~absent
    ellipses = only.ellipses[used]
    if len(ellipses):
        space = Coordinates.of([Ellipse(*row) for row in ellipses.tolist()], only.ellipses)
        used &= ~outliers(space.values(only.ellipses)[:, :4], used, GATE)
    return Support(used[None].copy(), only.confidence)


def both(
    stretch: Stretch, forward: Course, backward: Course, absent: Flags, *, same_end: bool = False
) -> Support:
    """Return the support of two passes, judged by each other and by the keyframes at their ends.

    With `same_end`, there is no keyframe at the end: the backward pass began at the forward one.
    """
    agree = iou(enclosing(forward.ellipses), enclosing(backward.ellipses)) > HALF
    ends = (forward.ellipses[-1], stretch.end), (backward.ellipses[0], stretch.begin)
    forward_meets, backward_meets = (
        key is not None and bool(iou(Ellipse(*place.tolist()).box, as_ellipse(key).box) > HALF)
        for place, key in ends
    )
    confidence = np.array([forward.confidence, backward.confidence])
    meets = (None if same_end else forward_meets, backward_meets)
    return support(confidence, agree, meets, absent)


def fuse(
    passes: Sequence[Course],
    follows: Support,
    marks: dict[int, Region],
    starts: Sequence[int],
    absent: Flags,
) -> Course:
    """Return one track from one or two passes.

    The passes are over the same frames, and `follows` is which of them are used in each. `marks`
    has exact regions by their place in these frames, and `starts` where each pass has begun, on one
    of them; none for a track whose start is not known. `absent` (n,) is whether the target is known
    to be absent.
    """
    used = follows.used
    keys = {i: as_ellipse(mark) for i, mark in marks.items()}
    boxes = all(isinstance(mark, Box) for mark in marks.values()) if marks else None
    regions = [*keys.values()] or [Ellipse(*row) for row in passes[0].ellipses[used[0]].tolist()]
    space = Coordinates.of(regions, passes[0].ellipses, boxes)
    seen = np.array([space.values(each.ellipses) for each in passes])
    relative = np.array([space.relative(each.ellipses, each.variances) for each in passes])
    exact = {i: space.values(np.array([key]), i)[0] for i, key in keys.items()}
    surest = int(used.sum(axis=1).argmax())
    motion = fit_motion(seen[surest], used[surest], relative[surest])
    for i, start in enumerate(starts):
        relative[i, start] = 0.0
    drift = Drift(*(each[: space.dimensions] for each in DRIFT))
    hidden = shared_variance(len(absent), [*keys], drift)
    if len(passes) == 2:
        motion = motion._replace(acceleration=SHARED_MOTION * motion.acceleration)
        path = smoothed(seen, used, relative, exact, motion, drift)
    else:  # the drift of one pass alone cannot be told from motion
        path = smoothed(seen, used, relative, exact, motion, None)
        hidden *= 2
    ellipses, variances = space.ellipses(path.mean, path.variance + hidden)
    if not keys:  # nothing shows how far the pass has gone: it is not surer than the tracker was
        variances = np.fmax(variances, passes[0].variances)
    confidence = overlap_probability(ellipses, variances, HALF)
    if not keys:
        confidence = np.fmin(confidence, passes[0].confidence)

    supported: Flags = np.logical_or.reduce(used, axis=0)
    supported[[*keys]] = True
    bridged = _bridged(supported, absent)
    lost = ~(supported | bridged | absent)
    before = space.ellipses(seen[0], relative[0])[0] if keys else passes[0].ellipses
    ellipses[lost], variances[lost] = before[lost], passes[0].variances[lost]
    confidence = np.where(supported, follows.probability, confidence)
    confidence[lost] = np.minimum(passes[0].confidence[lost], HALF)  # what it claims is refused
    for i, key in keys.items():  # as the user has marked it
        ellipses[i], variances[i], confidence[i] = key, 0.0, 1.0
    ellipses[absent], variances[absent], confidence[absent] = math.nan, math.nan, math.nan
    claims = np.array([each.where(Status.TRACKING) for each in passes])
    outlier = (claims & ~used).any(axis=0) & ~absent
    outlier[[*keys]] = False
    states = np.select([absent, supported, bridged], [0, 1, 2], 3)
    names = (Status.ABSENT, Status.TRACKING, Status.INTERPOLATED, Status.LOST)
    return Course(ellipses, variances, confidence, [names[i] for i in states], outlier)


def enclosing(ellipses: Floats) -> Floats:
    """Return the smallest boxes x, y, w, h (n, 4) around ellipses (n, 5), as `Ellipse.box`."""
    return np.array([Ellipse(*row).box for row in ellipses.tolist()]).reshape(-1, 4)


def shared_variance(count: int, keys: Sequence[int], drift: Drift = DRIFT) -> Floats:
    """Return the variance (n, k) of what all passes have in common, such as parts that they follow.

    No pass shows it. It is taken to be as large as the drift of one pass, from the next keyframe.
    """
    if not keys:
        return np.tile(drift.deviation**2, (count, 1))
    away = np.abs(np.arange(count)[:, None] - np.array(keys)).min(axis=1)
    out: Floats = drift.deviation**2 * -np.expm1(-2 * away[:, None] / drift.memory)
    return out


def _bridged(supported: Flags, absent: Flags) -> Flags:
    """Return the frames without support that lie between two supports, with no absence between."""
    place = np.arange(len(supported))
    before = np.maximum.accumulate(np.where(supported, place, -1))
    after = np.minimum.accumulate(np.where(supported, place, len(place))[::-1])[::-1]
    marks = np.append(0, np.cumsum(absent))
    gone = marks[after] - marks[np.maximum(before, 0)] > 0
    out: Flags = ~supported & ~absent & (before >= 0) & (after < len(place)) & ~gone
    return out
