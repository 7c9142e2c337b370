"""What the process of a camera does: frames come in, and a report of each goes out."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import suppress

import msgspec

from motes import Frame, KnownTarget, MotesError, Scene, Source, named_detector, open_source
from motes.core import WorkerLine
from motes.video import Newest, is_recorded
from motes_fleet.cameras.camera_report import (
    Arrival,
    CameraEnded,
    CameraMessage,
    CameraReady,
    Go,
    NextFrame,
)
from motes_fleet.cameras.camera_reporter import CameraReporter
from motes_fleet.cameras.known_target import KnownTargetReporter
from motes_fleet.cameras.live import on_clock, opened
from motes_fleet.cameras.rig_config import Camera

PRESET = "nummiaro:adaptive"
"""The preset of the filters that follow all objects."""


def watch_camera(
    line: WorkerLine, camera: Camera, seed: int, origin: float, target: KnownTarget | None
) -> None:
    """Watch a camera until it ends, or nobody receives its reports any more; in its own process.

    `origin` is the reading of `time.monotonic` at time 0 of live frames. It waits for a known
    `target`, if there is one, in place of all objects.
    """
    with suppress(BrokenPipeError):
        line.send(_watched(line, camera, seed, origin, target))


def _watched(
    line: WorkerLine, camera: Camera, seed: int, origin: float, target: KnownTarget | None
) -> CameraEnded:
    """Send a report of each frame of a camera; return how it ended."""
    frames, dropped, failure = 0, 0, None

    def tell(text: str) -> None:
        line.send(CameraMessage(camera.name, text))

    def ready(live: bool) -> None:
        line.send(CameraReady(camera.name, live))

    try:
        reporter = _reporter_of(camera, seed, target)
        film, live = opened(camera.source, camera.fps, tell, ready)
        with film:
            pairs = _live(film, line, origin) if live else _recorded(film, line, camera)
            for frame, arrivals in pairs:
                reporter.expect(arrivals)
                line.send(reporter.report(frame))
                frames += 1
                dropped = frame.index + 1 - frames
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
    if is_recorded(camera.source):
        with open_source(camera.source, fps=camera.fps) as film:
            scene.prepare(film)
    return CameraReporter(camera, scene, seed)


def _live(
    film: Source, line: WorkerLine, origin: float
) -> Iterator[tuple[Frame, Sequence[Arrival]]]:
    """Yield the newest frames of a live camera, and what may be expected from each on."""
    with Newest(film) as frames:
        for frame in on_clock(frames, origin):
            found: list[Arrival] = []
            while line.waiting:
                found += _arrivals(line)
            yield frame, found


def _recorded(
    film: Source, line: WorkerLine, camera: Camera
) -> Iterator[tuple[Frame, Sequence[Arrival]]]:
    """Yield the same of a recording.

    The next frame is announced before the work on one begins, so that it is always known how far
    the other cameras may go.
    """
    if film.report.assumption is not None:
        told = film.report.assumption.replace("--fps", "fps in its [[camera]]")
        line.send(CameraMessage(camera.name, told))
    last: tuple[Frame, Sequence[Arrival]] | None = None
    failure: MotesError | None = None
    try:
        for each in film:
            frame = Frame(each.index, each.time + camera.offset, each.pixels)
            line.send(NextFrame(frame.time))
            if last is not None:
                yield last
            last = frame, _arrivals(line)
    except MotesError as error:  # of the film; the frame before it is whole
        failure = error
    if last is not None:
        yield last
    if failure is not None:
        raise failure
    if film.report.problems is not None:
        line.send(CameraMessage(camera.name, film.report.problems))


def _arrivals(line: WorkerLine) -> tuple[Arrival, ...]:
    """Wait for a `Go`, and return what it lets expect."""
    return msgspec.msgpack.decode(line.receive(), type=Go).arrivals
