"""A camera of a rig, seen from where reports meet: its reports, its frames, and its restarts."""

from __future__ import annotations

import math
import time
from collections import deque
from collections.abc import Iterator
from multiprocessing.connection import Connection

import msgspec
from msgspec.structs import replace

from motes import KnownTarget
from motes.core import Worker
from motes.video import pauses
from motes_fleet.cameras.camera_loop import watch_camera
from motes_fleet.cameras.camera_report import (
    Arrival,
    CameraEnded,
    CameraMessage,
    CameraReady,
    CameraReport,
    Go,
    Message,
    NextFrame,
    ObjectReport,
)
from motes_fleet.cameras.reidentification import CAMERA_TIMEOUT
from motes_fleet.cameras.rig_config import Camera

DELAY = 0.03
"""Seconds from a report until other recordings know it: less than a frame.

So a camera knows in a frame what the others saw in the frame before, and all work at the same time.
"""
SILENCE = 10.0
"""Seconds without a report after which a live camera is said to be silent: its driver hangs, where
no time limit of FFmpeg reaches, or its detector."""


class RigCamera:
    """A camera whose process runs `watch_camera`, at the other end of a pipe.

    A process that ends without a `CameraEnded` is started again, after growing pauses.

    - The new process of a live camera has new objects. The rig may reidentify them by their looks.
    - The new process of a recording begins with its first frame. Reports that came before are left
      out. If it ends at the same frame again, the camera is given up.

    Parameters
    ----------
    camera, seed, origin, target
        As for `watch_camera`.

    Attributes
    ----------
    pipe
        The pipe to its process; None if there is nothing to be heard.
    reports
        Reports that wait for their time.
    live, over
        Whether it is live, and whether it has ended.
    next
        The time of the frame for which a recording waits for a `Go`.
    due
        When it will be started again; None while it runs, and after its end.
    """

    def __init__(
        self, camera: Camera, seed: int, origin: float, target: KnownTarget | None = None
    ) -> None:
        self.name, self._args = camera.name, (camera, seed, origin, target)
        self.pipe: Connection | None = None
        self.reports: deque[CameraReport] = deque()
        self.live = self.over = False
        self.next: float | None = None
        self.due: float | None = None
        self._working: deque[float] = deque()
        """The times of the frames of which reports will come."""
        self._last = -math.inf
        """The time of the last `NextFrame`."""
        self._log: list[tuple[Arrival, ...]] = []
        """What a recording was sent for each frame, for a process that begins anew."""
        self._asked = 0
        self._told = False
        """Whether a live camera has been sent arrivals since its last report."""
        self._reported = self._frames = self._identities = 0
        """The number of reports, and the first free numbers of frames and identities."""
        self._ended: float | None = None
        self._heard = math.inf
        """When a live camera has reported last; infinite from when it is said to be away."""
        self._failed_at, self._pauses = -1, pauses(CAMERA_TIMEOUT)
        self.start()

    def start(self) -> None:
        """Start the process."""
        self.worker = Worker(watch_camera, *self._args)
        self.pipe = self.worker.pipe
        self.due = self.next = None
        self._asked, self._told = 0, False
        self._known = 0 if self.live else self._reported
        self._offsets = (self._frames, self._identities) if self.live else (0, 0)

    def close(self) -> None:
        """End the process."""
        self.worker.end()

    def look(self) -> Iterator[CameraMessage]:
        """Start it again if that is due; yield once that a live camera is silent."""
        now = time.monotonic()
        if self.due is not None and now >= self.due:
            self.start()
        if now - self._heard > SILENCE:
            yield CameraMessage(self.name, f"nothing has come from it for {SILENCE:g} s.")
            self._ended, self._heard = self._heard, math.inf

    def listen(self) -> Iterator[CameraMessage | CameraEnded]:
        """Receive its next message; yield it unless it is a report, which waits for its time."""
        assert self.pipe is not None
        message: Message | None = self.worker.receive(Message)
        if message is not None:
            yield from self.receive(message)
            return
        self.pipe = None
        cause = self.worker.cause()
        self.worker.end()
        yield from self.fail(f"its process ended with {cause}")

    def _send(self, arrivals: tuple[Arrival, ...]) -> None:
        """Send a `Go`."""
        if self.pipe is not None:
            self.worker.send(msgspec.msgpack.encode(Go(arrivals)))

    def upcoming(self) -> tuple[float, int, bool]:
        """Return the next event of a recording: its key in time, its kind, and whether it is known.

        Kind 0 is a report, whose key is its time. Kind 1 is a `Go`, which takes into account what
        was reported up to `DELAY` earlier. For an event that is not known yet, the key is the least
        that it may have.
        """
        if self.over:
            return (self.reports[0].time if self.reports else math.inf), 0, True
        at = self._last if self.next is None else self.next
        events = [(at - DELAY, 1, self.next is not None)]
        if self.reports:
            events.append((self.reports[0].time, 0, True))
        elif self._working:
            events.append((self._working[0], 0, False))
        return min(events)

    def go(self, arrivals: tuple[Arrival, ...]) -> None:
        """Let a recording work on its next frame."""
        assert self.next is not None
        self._working.append(self.next)
        self.next = None
        self._log.append(arrivals)
        self._send(arrivals)

    @property
    def listens(self) -> bool:
        """Whether it is a live camera that has worked since it was sent arrivals.

        Only then are arrivals asked for: some are announced once, and would be lost. And a camera
        that hangs is never sent more than its pipe holds.
        """
        return self.live and not self._told and self.due is None and not self.over

    def send_arrivals(self, arrivals: tuple[Arrival, ...]) -> None:
        """Send arrivals to a camera that listens."""
        if arrivals:
            self._told = True
            self._send(arrivals)

    def receive(self, message: Message) -> Iterator[CameraMessage | CameraEnded]:
        """Take a message; yield it unless it is a report, which waits for its time."""
        if isinstance(message, CameraReport):
            yield from self._take(message)
        elif isinstance(message, CameraReady):
            self.live = message.live
        elif isinstance(message, NextFrame):
            self._asked += 1
            if self._asked <= len(self._log):  # an earlier process had it
                self._send(self._log[self._asked - 1])
            else:
                self.next = self._last = message.time
        else:
            self._heard = math.inf
            self.over = isinstance(message, CameraEnded)
            yield message

    def _take(self, report: CameraReport) -> Iterator[CameraMessage]:
        """Keep a new report, with numbers that no earlier process has used."""
        self._told = False
        self._heard = time.monotonic() if self.live else math.inf
        if self._known:
            self._known -= 1
            return
        if self._working:
            self._working.popleft()
        if self._ended is not None:
            away = time.monotonic() - self._ended
            self._ended = None
            yield CameraMessage(self.name, f"it is back after {away:.1f} s.")
        self._reported += 1
        first, first_identity = self._offsets
        sightings = tuple(_renumbered(each, first_identity) for each in report.sightings)
        report = replace(report, frame=report.frame + first, sightings=sightings)
        self._frames = report.frame + 1
        self._identities = max([self._identities, *(each.identity for each in sightings)])
        self.reports.append(report)

    def fail(self, why: str) -> Iterator[CameraMessage | CameraEnded]:
        """Yield once that it failed; start it again later, or give a recording up."""
        again = self._failed_at == self._reported
        if again and not self.live:
            self.over = True
            yield CameraEnded(self.name, self._reported, failure=why)
            return
        if not again:
            self._pauses = pauses(CAMERA_TIMEOUT)
        self.due, self._failed_at = time.monotonic() + next(self._pauses), self._reported
        self._heard = math.inf
        if self._ended is None:
            self._ended = time.monotonic()
            yield CameraMessage(self.name, f"{why}. It is started again, with growing pauses.")


def _renumbered(sighting: ObjectReport, offset: int) -> ObjectReport:
    """Return a report with an offset added to its identities."""
    occluded_by = None if sighting.occluded_by is None else sighting.occluded_by + offset
    return replace(sighting, identity=sighting.identity + offset, occluded_by=occluded_by)
