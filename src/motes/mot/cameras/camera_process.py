"""The process of a camera: `CameraProcess` in the main process, `_serve` in its own."""

from __future__ import annotations

import multiprocessing
import os
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
from motes.mot.cameras.camera_report import CameraReport, ObjectReport
from motes.mot.cameras.camera_reporter import (
    CameraEnded,
    CameraMessage,
    CameraReporter,
    Message,
    Ready,
)
from motes.mot.cameras.reidentification import CAMERA_TIMEOUT
from motes.mot.cameras.rig_config import Camera
from motes.mot.pipeline_config import named_detector
from motes.mot.scene import Scene
from motes.video.live import Live, open_watched
from motes.video.reconnect import LONGEST_PAUSE


class CameraProcess:
    """The process of a camera, seen from the main process.

    A process that ends without a `CameraEnded` is started again, after growing pauses.

    - The new process of a live camera has new objects. The rig may reidentify them by their looks.
    - The new process of a recording begins with its first frame. Reports that came before are left
      out. If it ends at the same frame again, the camera is given up.
    """

    def __init__(self, camera: Camera, seed: int, origin: float) -> None:
        self.name = camera.name
        self.reports: deque[CameraReport] = deque()
        self.live = self.over = False
        self.due: float | None = None
        """When it will be started again; None while it runs, and after its end."""
        self._args = camera, seed, origin
        self._reported = self._frames = self._identities = 0
        """The number of reports, and the first free numbers of frames and identities."""
        self._ended: float | None = None
        self._failed_at, self._pause = -1, CAMERA_TIMEOUT
        self._start()

    def _start(self) -> None:
        """Start the process."""
        context = multiprocessing.get_context("spawn")
        with blocked_signals():
            self.pipe, theirs = context.Pipe(duplex=False)
            args = (theirs, *self._args)
            self.process = context.Process(target=_serve, args=args, daemon=True)
            self.process.start()
            theirs.close()
        self.due = None
        self._known = 0 if self.live else self._reported
        self._offsets = (self._frames, self._identities) if self.live else (0, 0)

    @property
    def awaited(self) -> bool:
        """Whether other cameras have to wait for its next report."""
        return not (self.live or self.over or self.reports)

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
        else:
            self.over = isinstance(message, CameraEnded)
            yield message

    def _take(self, report: CameraReport) -> Iterator[CameraMessage]:
        """Keep a new report, with numbers that no earlier process has used."""
        if self._known:
            self._known -= 1
            return
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


def _serve(pipe: Connection, camera: Camera, seed: int, origin: float) -> None:
    """Watch a camera until it ends, and send a report of each frame."""
    os.dup2(2, 1)  # standard output is for rows
    parent = multiprocessing.parent_process()
    assert parent is not None
    threading.Thread(target=_end_with, args=(parent.sentinel,), daemon=True).start()
    frames, dropped, failure = 0, 0, None

    def send(message: Message) -> None:
        pipe.send_bytes(msgspec.msgpack.encode(message))

    with suppress(BrokenPipeError):
        try:
            reporter = CameraReporter(
                camera, Scene(named_detector(camera.detector), camera.preset, seed)
            )
            with open_watched(camera.source, origin) as film:
                live = isinstance(film, Live)
                send(Ready(camera.name, live))
                for news in film:
                    if isinstance(news, str):
                        send(CameraMessage(camera.name, news))
                        continue
                    offset = 0.0 if live else camera.offset
                    send(reporter.report(Frame(news.index, news.time + offset, news.pixels)))
                    frames, dropped = frames + 1, film.dropped if isinstance(film, Live) else 0
        except MotesError as error:
            failure = str(error)
        except BrokenPipeError:
            raise
        except Exception as error:  # a failure of one camera ends no other
            failure = f"{type(error).__name__}: {error}"
        send(CameraEnded(camera.name, frames, dropped, failure))


def _end_with(sentinel: int) -> None:
    """End this process when the main process ends, for whatever reason."""
    wait([sentinel])
    os._exit(1)
