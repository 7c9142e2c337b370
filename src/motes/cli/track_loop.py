"""From frames to tracks, without a word to anyone: the loop of the command line."""

from __future__ import annotations

import time
from collections.abc import Callable, Generator, Iterable, Sequence
from dataclasses import dataclass

from motes.core.detection import Detector
from motes.core.frame import Frame
from motes.core.track import Status, Track
from motes.sot.known_target import Place, Target
from motes.sot.step_info import StepInfo
from motes.sot.tracker import Picture, Tracker


@dataclass(frozen=True, slots=True)
class Step:
    """What became of a frame.

    Attributes
    ----------
    frame
        The frame.
    info
        What the tracker says; None while it waits for something to follow.
    seconds
        How long that took.
    """

    frame: Frame
    info: StepInfo | None
    seconds: float

    @property
    def track(self) -> Track | None:
        """Where the target is."""
        return self.info.track if self.info else None

    @property
    def status(self) -> Status:
        """The track's; without one, the target is searched for."""
        return self.info.track.status if self.info else Status.SEARCHING


Begin = Callable[[Tracker, Frame], bool]
"""Tries to start a tracker on a frame and tells whether it has."""


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


def on_target(target: Target, places: Sequence[Place], background: Picture | None) -> Begin:
    """Start by looking for a known target."""

    def begin(tracker: Tracker, frame: Frame) -> bool:
        tracker.search(frame, target, places, background)
        return True

    return begin


def follow(tracker: Tracker, begin: Begin, frames: Iterable[Frame]) -> Generator[Step, None, None]:
    """Yield a step for each frame."""
    begun = False
    for frame in frames:
        clock = time.perf_counter()
        if begun:
            tracker.update(frame)
        else:
            begun = begin(tracker, frame)
        yield Step(frame, tracker.info if begun else None, time.perf_counter() - clock)


class Companion:
    """A mean-shift tracker that runs beside another one, for comparison.

    It starts where the other one first tracks the target.
    """

    def __init__(self) -> None:
        self._tracker = Tracker("mean_shift")
        self._begun = False

    def seconds(self, step: Step) -> float | None:
        """Follow the target in a step's frame; return how long that took, None before it began."""
        if self._begun:
            clock = time.perf_counter()
            self._tracker.update(step.frame)
            return time.perf_counter() - clock
        if step.track is not None and step.status is Status.TRACKING:
            self._tracker.init(step.frame, step.track.box)
            self._begun = True
        return None
