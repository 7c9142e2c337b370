"""What the process of a camera does: frames come in, and a report of each goes out."""

from __future__ import annotations

import os
import queue
import threading
from collections.abc import Iterator, Sequence
from contextlib import suppress
from multiprocessing.connection import Connection

import msgspec

from motes.core.errors import MotesError
from motes.core.frame import Frame
from motes.mot.cameras.camera_report import (
    Arrival,
    CameraEnded,
    CameraMessage,
    CameraReady,
    Go,
    Message,
    NextFrame,
)
from motes.mot.cameras.camera_reporter import CameraReporter
from motes.mot.cameras.known_target import KnownTargetReporter
from motes.mot.cameras.rig_config import Camera
from motes.mot.pipeline_config import named_detector
from motes.mot.scene import Scene
from motes.sot.known_target import KnownTarget
from motes.video.live import Live, open_watched
from motes.video.sources import Source

PRESET = "nummiaro:adaptive"
"""The preset of the filters that follow all objects."""


class PipeLine:
    """The line from a camera's process to the main process; it ends this one with that one."""

    def __init__(self, pipe: Connection) -> None:
        self._pipe = pipe
        self._inbox: queue.SimpleQueue[Go] = queue.SimpleQueue()
        threading.Thread(target=_receive, args=(pipe, self._inbox), daemon=True).start()

    def send(self, message: Message) -> None:
        """Send a message; wait while the pipe is full.

        Raises
        ------
        BrokenPipeError
            If there is no receiver any more.
        """
        self._pipe.send_bytes(msgspec.msgpack.encode(message))

    def go(self) -> Go:
        """Wait for the `Go` of the frame that was announced last."""
        return self._inbox.get()

    def arrivals(self) -> Sequence[Arrival]:
        """Return the arrivals that a live camera has been sent since the last call."""
        found: list[Arrival] = []
        while not self._inbox.empty():
            found += self._inbox.get().arrivals
        return found


def _receive(pipe: Connection, inbox: queue.SimpleQueue[Go]) -> None:
    """Receive what the main process sends; end this process when that one ends, for any reason.

    The main process never waits for a camera that is at work: messages are taken at once.
    """
    while True:
        try:
            inbox.put(msgspec.msgpack.decode(pipe.recv_bytes(), type=Go))
        except (EOFError, OSError):
            os._exit(1)


def watch_camera(
    pipe: Connection, camera: Camera, seed: int, origin: float, target: KnownTarget | None
) -> None:
    """Watch a camera until it ends, or nobody receives its reports any more; in its own process.

    Parameters
    ----------
    pipe
        To the place where reports meet.
    camera
        The camera.
    seed
        Seed of the random numbers.
    origin
        The reading of `time.monotonic` at time 0 of live frames.
    target
        The known target for which it waits, in place of all objects.
    """
    os.dup2(2, 1)  # standard output is for rows
    with suppress(BrokenPipeError):
        line = PipeLine(pipe)
        line.send(_watched(line, camera, seed, origin, target))


def _watched(
    line: PipeLine, camera: Camera, seed: int, origin: float, target: KnownTarget | None
) -> CameraEnded:
    """Send a report of each frame of a camera; return how it ended."""
    frames, dropped, failure = 0, 0, None
    try:
        reporter = _reporter_of(camera, seed, target)
        with open_watched(camera.source, origin, camera.fps) as film:
            line.send(CameraReady(camera.name, isinstance(film, Live)))
            if isinstance(film, Live):
                pairs = _live(film, line, camera)
            else:
                pairs = _recorded(film, line, camera)
            for frame, arrivals in pairs:
                reporter.expect(arrivals)
                line.send(reporter.report(frame))
                frames += 1
                dropped = film.dropped if isinstance(film, Live) else 0
    except MotesError as error:
        failure = str(error)
    except BrokenPipeError:
        raise
    except Exception as error:  # a failure of one camera ends no other
        failure = f"{type(error).__name__}: {error}"
    return CameraEnded(camera.name, frames, dropped, failure)


def _reporter_of(
    camera: Camera, seed: int, target: KnownTarget | None
) -> CameraReporter | KnownTargetReporter:
    """Return what makes a camera's reports: of a known target, or of all objects."""
    if target is not None:
        return KnownTargetReporter(camera, target, seed)
    scene = Scene(named_detector(camera.detector), camera.preset or PRESET, seed)
    return CameraReporter(camera, scene, seed)


def _live(film: Live, line: PipeLine, camera: Camera) -> Iterator[tuple[Frame, Sequence[Arrival]]]:
    """Yield the frames of a live camera, and what may be expected from each on."""
    for news in film:
        if isinstance(news, str):
            line.send(CameraMessage(camera.name, news))
        else:
            yield news, line.arrivals()


def _recorded(
    film: Source, line: PipeLine, camera: Camera
) -> Iterator[tuple[Frame, Sequence[Arrival]]]:
    """Yield the same of a recording.

    The next frame is announced before the work on one begins, so that it is always known how far
    the other cameras may go.
    """
    if film.report.assumption is not None:
        line.send(CameraMessage(camera.name, film.report.assumption))
    last: tuple[Frame, Sequence[Arrival]] | None = None
    for each in film:
        frame = Frame(each.index, each.time + camera.offset, each.pixels)
        line.send(NextFrame(frame.time))
        if last is not None:
            yield last
        last = frame, line.go().arrivals
    if last is not None:
        yield last
