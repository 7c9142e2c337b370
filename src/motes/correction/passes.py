"""A pass: one tracker over some frames, forward or backward, from a keyframe."""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Iterable, Sequence
from typing import NamedTuple

import numpy as np
from msgspec.structs import replace

from motes.core.errors import ConfigError
from motes.core.frame import Frame
from motes.core.geometry import Ellipse
from motes.core.interrupts import check
from motes.core.track import Status, Track
from motes.core.types import Flags, Floats, Numbers
from motes.sot.algorithm import StepInfo
from motes.sot.presets import TrackerConfig
from motes.sot.tracker import Tracker


class Course(NamedTuple):
    """Where a target is in frames in order, as arrays: of one pass, or of all that is known."""

    ellipses: Floats
    variances: Floats
    """(n, 5), x, y, a, b, theta and their variances; NaN where the target is absent."""
    confidence: Floats
    """(n,)."""
    status: Sequence[Status]
    """The status of each frame."""
    outlier: Flags
    """(n,), whether a tracker reported a place that is not used."""

    @classmethod
    def of(cls, tracks: Sequence[Track]) -> Course:
        """Return tracks, in order of their frames, as a course; raise a ConfigError for others."""
        check_tracks(tracks)
        return cls(
            np.array([track.ellipse for track in tracks], np.float64).reshape(-1, 5),
            np.array([track.covariance.diagonal() for track in tracks]).reshape(-1, 5),
            np.array([track.confidence for track in tracks], np.float64),
            [track.status for track in tracks],
            np.array([track.outlier for track in tracks], bool),
        )

    def where(self, *states: Status) -> Flags:
        """Return in which frames (n,) the status is one of these."""
        return np.array([each in states for each in self.status], bool)

    def tracks(self, like: Sequence[Track]) -> list[Track]:
        """Return tracks with this course, and all else of other tracks of the same frames."""
        return [
            replace(
                track,
                ellipse=Ellipse(*self.ellipses[i].tolist()),
                covariance=np.diag(self.variances[i]),
                confidence=float(self.confidence[i]),
                status=self.status[i],
                outlier=bool(self.outlier[i]),
                smoothed=True,
            )
            for i, track in enumerate(like)
        ]


def check_tracks(tracks: object) -> None:
    """Raise a ConfigError if these are no `Track`s in a list, as rows of `read_track`."""
    for each in tracks if isinstance(tracks, Collection) else [None]:
        if not isinstance(each, Track):
            raise ConfigError(
                "Give the Track of each frame, as Tracker.update returns it; rows of a file are "
                "for the commands motes smooth, check and refine."
            )


def run_pass(
    config: TrackerConfig,
    seed: int,
    frames: Iterable[Frame],
    region: Numbers,
    *,
    backward: bool = False,
    so_far: list[Track] | None = None,
    other: tuple[Frame, Numbers] | None = None,
    observe: Callable[[StepInfo], None] | None = None,
) -> list[Track]:
    """Return the tracks of a target, in order of the frames.

    The frames are in the order of the pass, and `region` is the target in the first one. Each track
    is added to `so_far` as soon as it is known, for a run that is interrupted. The models also
    learn from the look of `other`, the keyframe at the end of the pass; `observe` gets the
    tracker's report of each frame.
    """
    tracker = Tracker(config, seed, backward=backward)
    tracks = [] if so_far is None else so_far
    for frame in frames:
        if tracks:
            tracks.append(tracker.update(frame))
        else:
            if len(region) == 5:  # a target may have turned on and on
                region = [*region[:4], math.fmod(region[4], 2 * math.pi)]
            tracks.append(tracker.init(frame, region))
            if other is not None:
                tracker.learn_also(*other)
        if observe is not None:
            observe(tracker.info)
        check()
    return tracks[::-1] if backward else tracks
