"""The moments of `motes track`: from frames to tracks, without input or output."""

from __future__ import annotations

import time
from collections.abc import Callable, Generator, Iterable, Sequence

from motes.cli.moment import Moment
from motes.core.detection import Detector
from motes.core.frame import Frame
from motes.core.track import Status
from motes.sot.known_target import KnownTarget
from motes.sot.places import Place
from motes.sot.tracker import Picture, Tracker

Begin = Callable[[Tracker, Frame], bool]
"""Tries to start a tracker on a frame; returns whether it has started."""


def on_region(region: Sequence[float]) -> Begin:
    """Start on the object in a region of the first frame."""

    def begin(tracker: Tracker, frame: Frame) -> bool:
        tracker.init(frame, region)
        return True

    return begin


def on_detection(detector: Detector) -> Begin:
    """Start on the surest detection, in the first frame that has one."""

    def begin(tracker: Tracker, frame: Frame) -> bool:
        return tracker.detect(frame, detector) is not None

    return begin


def on_target(target: KnownTarget, places: Sequence[Place], background: Picture | None) -> Begin:
    """Start by searching for a known target."""

    def begin(tracker: Tracker, frame: Frame) -> bool:
        tracker.search(frame, target, places, background)
        return True

    return begin


def follow(
    tracker: Tracker, begin: Begin, frames: Iterable[Frame]
) -> Generator[Moment, None, None]:
    """Yield a moment for each frame."""
    begun = False
    for frame in frames:
        clock = time.perf_counter()
        if begun:
            tracker.update(frame)
        else:
            begun = begin(tracker, frame)
        yield Moment(frame, tracker.info if begun else None, time.perf_counter() - clock)


class Companion:
    """A mean-shift tracker that runs beside another one, for comparison.

    It starts on the frame in which the other one first tracks the target.
    """

    def __init__(self) -> None:
        self._tracker = Tracker("mean_shift")
        self._begun = False

    def seconds(self, moment: Moment) -> float | None:
        """Track the target in a frame; return the time in seconds, None before the start."""
        if self._begun:
            clock = time.perf_counter()
            self._tracker.update(moment.frame)
            return time.perf_counter() - clock
        if moment.track is not None and moment.status is Status.TRACKING:
            self._tracker.init(moment.frame, moment.track.box)
            self._begun = True
        return None
