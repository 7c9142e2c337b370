"""The steps of `motes track`: from frames to tracks, without input or output."""

from __future__ import annotations

import time
from collections.abc import Callable, Generator, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from motes.core.detection import Detector
from motes.core.frame import Frame
from motes.core.track import Status, Track
from motes.core.types import Floats
from motes.mot.analytics.real_units import GroundPlace
from motes.rows.journal import FrameRow, ObjectRow
from motes.rows.schema import hindsight
from motes.sot.known_target import KnownTarget
from motes.sot.places import Place
from motes.sot.step_info import StepInfo
from motes.sot.tracker import Picture, Tracker


class Hindsight(NamedTuple):
    """What is known of a frame in hindsight, in the form of a `StepInfo`: no particles."""

    track: Track
    ellipses: Floats = np.empty((0, 5))
    weights: Floats = np.empty(0)
    n_supporting: None = None
    models: Mapping[str, Any] = {}
    cue_weights: Mapping[str, float] = {}


@dataclass(frozen=True, slots=True)
class Step:
    """The result of a frame.

    Attributes
    ----------
    frame
        The frame.
    info
        The tracker's report; None before it has a target.
    seconds
        Time of the tracker.
    place
        The target's place on the ground; None if it is not measured, or not seen.
    """

    frame: Frame
    info: StepInfo | None
    seconds: float
    place: GroundPlace | None = None

    @property
    def picture(self) -> FrameRow:
        """The row of the frame."""
        known = hindsight(self.info.track) if isinstance(self.info, Hindsight) else {}
        further = known if self.place is None else known | self.place.columns
        target = ObjectRow.of_target(self.track, further)
        return FrameRow(self.frame.index, self.frame.time, (target,))

    @property
    def track(self) -> Track | None:
        """The target's track; None before there is a target."""
        return self.info.track if self.info else None

    @property
    def status(self) -> Status:
        """The track's status; without a track, searching."""
        return self.info.track.status if self.info else Status.SEARCHING


Steps = Callable[[Iterator[Frame]], Generator[Step, None, None]]
"""Makes the steps of a run from its frames."""
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

    It starts on the frame in which the other one first tracks the target.
    """

    def __init__(self) -> None:
        self._tracker = Tracker("mean_shift")
        self._begun = False

    def seconds(self, step: Step) -> float | None:
        """Track the target in a step's frame; return the time in seconds, None before the start."""
        if self._begun:
            clock = time.perf_counter()
            self._tracker.update(step.frame)
            return time.perf_counter() - clock
        if step.track is not None and step.status is Status.TRACKING:
            self._tracker.init(step.frame, step.track.box)
            self._begun = True
        return None
