"""The process of a camera: `CameraProcess` in the main process, `_serve` in its own."""

from __future__ import annotations

import math
import multiprocessing
import os
import queue
import threading
import time
from collections import deque
from collections.abc import Iterator
from contextlib import suppress
from multiprocessing.connection import Connection, wait

import msgspec
from msgspec.structs import replace

from motes.core.errors import MotesError
from motes.core.frame import Frame
from motes.core.worker_processes import blocked_signals, cause
from motes.mot.cameras.camera_report import Arrival, CameraReport, ObjectReport
from motes.mot.cameras.camera_reporter import CameraReporter
from motes.mot.cameras.known_target import KnownTargetReporter
from motes.mot.cameras.messages import (
    CameraEnded,
    CameraMessage,
    Go,
    Message,
    NextFrame,
    Ready,
)
from motes.mot.cameras.reidentification import CAMERA_TIMEOUT
from motes.mot.cameras.rig_config import Camera
from motes.mot.pipeline_config import named_detector
from motes.mot.scene import Scene
from motes.sot.known_target import Target
from motes.video.live import Live, open_watched
from motes.video.reconnect import LONGEST_PAUSE

PRESET = "nummiaro:adaptive"
"""The preset of the filters that follow all objects."""
DELAY = 0.03
"""Seconds from a report until other recordings know it: less than a frame.

So a camera knows in a frame what the others saw in the frame before, and all work at the same time.
"""


class CameraProcess:
    """The process of a camera, seen from the main process.

    A process that ends without a `CameraEnded` is started again, after growing pauses.

    - The new process of a live camera has new objects. The rig may reidentify them by their looks.
    - The new process of a recording begins with its first frame. Reports that came before are left
      out. If it ends at the same frame again, the camera is given up.
    """

    def __init__(
        self, camera: Camera, seed: int, origin: float, target: Target | None = None
    ) -> None:
        self.name = camera.name
        self.reports: deque[CameraReport] = deque()
        self.live = self.over = False
        self.next: float | None = None
        """The time of the frame for which a recording waits for a `Go`."""
        self.due: float | None = None
        """When it will be started again; None while it runs, and after its end."""
        self._args = camera, seed, origin, target
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
        self._failed_at, self._pause = -1, CAMERA_TIMEOUT
        self._start()

    def _start(self) -> None:
        """Start the process."""
        context = multiprocessing.get_context("spawn")
        with blocked_signals():
            self.pipe, theirs = context.Pipe()
            args = (theirs, *self._args)
            self.process = context.Process(target=_serve, args=args, daemon=True)
            self.process.start()
            theirs.close()
        self.due = self.next = None
        self._asked, self._told = 0, False
        self._known = 0 if self.live else self._reported
        self._offsets = (self._frames, self._identities) if self.live else (0, 0)

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

    def tell(self, arrivals: tuple[Arrival, ...]) -> None:
        """Send arrivals to a live camera, unless it has not worked since the last ones.

        So a camera that hangs is never sent more than its pipe holds.
        """
        if arrivals and not self._told and self.due is None and not self.over:
            self._told = True
            self._send(arrivals)

    def _send(self, arrivals: tuple[Arrival, ...]) -> None:
        with suppress(OSError):  # a process that died is noticed when it is listened to
            self.pipe.send_bytes(msgspec.msgpack.encode(Go(arrivals)))

    def revive(self) -> None:
        """Start it again if that is due."""
        if self.due is not None and time.monotonic() >= self.due:
            self.pipe.close()
            self._start()

    def listen(self) -> Iterator[CameraMessage | CameraEnded]:
        """Receive its next message; yield it unless it is a report, which waits for its time."""
        try:
            message = msgspec.msgpack.decode(self.pipe.recv_bytes(), type=Message)
        except (EOFError, OSError):
            self.process.join()
            yield from self._fail(f"its process ended with {cause(self.process.exitcode)}")
            return
        if isinstance(message, CameraReport):
            yield from self._take(message)
        elif isinstance(message, Ready):
            self.live = message.live
        elif isinstance(message, NextFrame):
            self._asked += 1
            if self._asked <= len(self._log):  # an earlier process had it
                self._send(self._log[self._asked - 1])
            else:
                self.next = self._last = message.time
        else:
            self.over = isinstance(message, CameraEnded)
            yield message

    def _take(self, report: CameraReport) -> Iterator[CameraMessage]:
        """Keep a new report, with numbers that no earlier process has used."""
        self._told = False
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

    def _fail(self, why: str) -> Iterator[CameraMessage | CameraEnded]:
        """Yield once that it failed; start it again later, or give a recording up."""
        again = self._failed_at == self._reported
        if again and not self.live:
            self.over = True
            yield CameraEnded(self.name, self._reported, failure=why)
            return
        self._pause = min(2 * self._pause, LONGEST_PAUSE) if again else CAMERA_TIMEOUT
        self.due, self._failed_at = time.monotonic() + self._pause, self._reported
        if self._ended is None:
            self._ended = time.monotonic()
            yield CameraMessage(self.name, f"{why}. It is started again, with growing pauses.")


def _renumbered(sighting: ObjectReport, offset: int) -> ObjectReport:
    """Return a report with an offset added to its identities."""
    occluded_by = None if sighting.occluded_by is None else sighting.occluded_by + offset
    return replace(sighting, identity=sighting.identity + offset, occluded_by=occluded_by)


def reporter_of(
    camera: Camera, seed: int, target: Target | None = None
) -> CameraReporter | KnownTargetReporter:
    """Return what makes a camera's reports: of a known target, or of all objects."""
    if target is not None:
        return KnownTargetReporter(camera, target, seed)
    scene = Scene(named_detector(camera.detector), camera.preset or PRESET, seed)
    return CameraReporter(camera, scene, seed)


def _serve(
    pipe: Connection, camera: Camera, seed: int, origin: float, target: Target | None
) -> None:
    """Watch a camera until it ends, and send a report of each frame."""
    os.dup2(2, 1)  # standard output is for rows
    inbox: queue.SimpleQueue[Go] = queue.SimpleQueue()
    threading.Thread(target=_receive, args=(pipe, inbox), daemon=True).start()
    frames, dropped, failure = 0, 0, None

    def send(message: Message) -> None:
        pipe.send_bytes(msgspec.msgpack.encode(message))

    def report(frame: Frame, go: Go) -> None:
        reporter.expect(go.arrivals)
        send(reporter.report(frame))

    with suppress(BrokenPipeError):
        try:
            reporter = reporter_of(camera, seed, target)
            with open_watched(camera.source, origin) as film:
                send(Ready(camera.name, isinstance(film, Live)))
                if isinstance(film, Live):
                    for news in film:
                        if isinstance(news, str):
                            send(CameraMessage(camera.name, news))
                            continue
                        while not inbox.empty():
                            reporter.expect(inbox.get().arrivals)
                        report(news, Go())
                        frames, dropped = frames + 1, film.dropped
                else:
                    # The next frame is announced before the work on one begins, so that the main
                    # process always knows how far the other cameras may go.
                    last: tuple[Frame, Go] | None = None
                    for each in film:
                        frame = Frame(each.index, each.time + camera.offset, each.pixels)
                        send(NextFrame(frame.time))
                        if last is not None:
                            report(*last)
                            frames += 1
                        last = frame, inbox.get()
                    if last is not None:
                        report(*last)
                        frames += 1
        except MotesError as error:
            failure = str(error)
        except BrokenPipeError:
            raise
        except Exception as error:  # a failure of one camera ends no other
            failure = f"{type(error).__name__}: {error}"
        send(CameraEnded(camera.name, frames, dropped, failure))


def _receive(pipe: Connection, inbox: queue.SimpleQueue[Go]) -> None:
    """Receive what the main process sends; end this process when that one ends, for any reason.

    The main process never waits for a camera that is at work: messages are taken at once.
    """
    parent = multiprocessing.parent_process()
    assert parent is not None
    while True:
        if parent.sentinel in wait([pipe, parent.sentinel]):
            os._exit(1)
        try:
            inbox.put(msgspec.msgpack.decode(pipe.recv_bytes(), type=Go))
        except (EOFError, OSError):
            os._exit(1)
