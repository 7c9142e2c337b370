"""A pass: one tracker over some frames, forward or backward, from a keyframe."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from motes.core.frame import Frame
from motes.core.geometry import Ellipse
from motes.core.interrupts import check
from motes.core.track import Status, Track
from motes.core.types import Floats
from motes.sot.presets import TrackerConfig
from motes.sot.step_info import StepInfo
from motes.sot.tracker import Tracker


class Pass(NamedTuple):
    """What a tracker has reported, in order of the frames, not of the pass."""

    ellipses: Floats
    """(n, 5)."""
    variances: Floats
    """(n, 5), the diagonal of each covariance."""
    confidence: Floats
    """(n,)."""
    tracking: NDArray[np.bool_]
    """(n,), whether its status was `tracking`."""

    def part(self, start: int, stop: int) -> Pass:
        """Return the frames from `start` on, before `stop`."""
        part = slice(start, stop)
        return Pass(
            self.ellipses[part], self.variances[part], self.confidence[part], self.tracking[part]
        )


def as_pass(tracks: Iterable[Track]) -> Pass:
    """Return tracks, in order of their frames, as a pass."""
    each = list(tracks)
    return Pass(
        np.array([track.ellipse for track in each], np.float64).reshape(-1, 5),
        np.array([track.covariance.diagonal() for track in each]).reshape(-1, 5),
        np.array([track.confidence for track in each], np.float64),
        np.array([track.status is Status.TRACKING for track in each], bool),
    )


def run_pass(
    config: TrackerConfig,
    seed: int,
    frames: Iterable[Frame],
    region: Ellipse,
    *,
    backward: bool = False,
    so_far: list[Track] | None = None,
    other: tuple[Frame, Ellipse] | None = None,
    observe: Callable[[StepInfo], None] | None = None,
) -> list[Track]:
    """Return the tracks of a target, in order of the frames.

    Parameters
    ----------
    config, seed
        The tracker.
    frames
        The frames in the order of the pass; the first one has the keyframe.
    region
        The target there.
    backward
        Whether the frames come in reverse order.
    so_far
        A list to which each track is added as soon as it is known, for a run that is interrupted.
    other
        The keyframe at the end of the pass, from whose look the models also learn.
    observe
        Called with the tracker's report of each frame.
    """
    tracker = Tracker(config, seed, backward=backward)
    tracks = [] if so_far is None else so_far
    for frame in frames:
        if tracks:
            tracks.append(tracker.update(frame))
        else:
            tracks.append(tracker.init(frame, region))
            if other is not None:
                tracker.learn_also(*other)
        if observe is not None:
            observe(tracker.info)
        check()
    return tracks[::-1] if backward else tracks
