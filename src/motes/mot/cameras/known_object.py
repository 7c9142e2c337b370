"""An object of one of several cameras, and what the rig knows of it."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from msgspec.structs import replace

from motes.core.track import Status
from motes.core.types import Floats
from motes.mot.cameras.camera_report import ObjectReport


@dataclass(slots=True, eq=False)
class KnownObject:
    """An object of a camera, and what is known of it.

    Attributes
    ----------
    camera, identity
        The camera's name, and the identity in the rig.
    seen
        Time of its last certain report.
    look
        Its last color histogram.
    last, tracked
        Its last report, and its last certain report.
    gone
        Whether it is lost.
    interrupted
        Whether its camera was interrupted since that certain report.
    passed
        Whether its identity now belongs to another object.
    announced
        Since when it is expected at other cameras, by their names.
    birth
        Its number among all objects of the rig, in the order of their births.
    """

    camera: str
    identity: int
    seen: float
    look: Floats
    last: ObjectReport
    tracked: ObjectReport
    gone: bool = False
    interrupted: bool = False
    passed: bool = False
    announced: dict[str, float] = field(default_factory=dict)
    birth: int = 0

    @classmethod
    def of(cls, camera: str, identity: int, now: float, report: ObjectReport) -> KnownObject:
        """Return a new object from its first report."""
        return cls(camera, identity, now, look_of(report), report, report)

    def note(self, report: ObjectReport, now: float) -> None:
        """Keep a new report; an object that is there again may be announced again."""
        if report.seen and not self.last.seen:
            self.announced.clear()
        self.last = report
        if report.histogram is not None:
            self.look = look_of(report)
        self.gone = report.status is Status.LOST
        if report.seen:
            self.seen, self.tracked, self.interrupted = now, report, False

    def lose(self) -> None:
        """Note that its camera will report it no more."""
        self.last, self.gone = replace(self.last, status=Status.LOST), True

    def visible(self, now: float, within: float) -> bool:
        """Return whether it was seen in its last report, at most some seconds ago."""
        return self.last.seen and not self.passed and now - self.seen <= within

    def foot(self, now: float) -> tuple[float, float]:
        """Return the middle of its lower edge, where it should be now."""
        (x, y), (dx, dy), dt = self.tracked.foot, self.tracked.velocity, now - self.seen
        return x + dx * dt, y + dy * dt


def look_of(report: ObjectReport) -> Floats:
    """Return the histogram of a report that has one."""
    assert report.histogram is not None
    return np.frombuffer(report.histogram, np.float32).astype(np.float64)
