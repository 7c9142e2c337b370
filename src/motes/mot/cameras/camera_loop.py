"""What the process of a camera does: frames come in, and a report of each goes out."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Protocol

from motes.core.errors import MotesError
from motes.core.frame import Frame
from motes.mot.cameras.camera_report import Arrival
from motes.mot.cameras.camera_reporter import CameraReporter
from motes.mot.cameras.known_target import KnownTargetReporter
from motes.mot.cameras.messages import (
    CameraEnded,
    CameraMessage,
    CameraReady,
    Go,
    Message,
    NextFrame,
)
from motes.mot.cameras.rig_config import Camera
from motes.mot.pipeline_config import named_detector
from motes.mot.scene import Scene
from motes.sot.known_target import KnownTarget
from motes.video.live import Live, open_watched
from motes.video.sources import Source

PRESET = "nummiaro:adaptive"
"""The preset of the filters that follow all objects."""


class ReportLine(Protocol):
    """The line from a camera to the place where reports meet."""

    def send(self, message: Message) -> None:
        """Send a message; raise a BrokenPipeError when there is no receiver any more."""

    def go(self) -> Go:
        """Wait for the `Go` of the frame that was announced last."""

    def arrivals(self) -> Sequence[Arrival]:
        """Return the arrivals that a live camera has been sent since the last call."""


def reporter_of(
    camera: Camera, seed: int, target: KnownTarget | None = None
) -> CameraReporter | KnownTargetReporter:
    """Return what makes a camera's reports: of a known target, or of all objects."""
    if target is not None:
        return KnownTargetReporter(camera, target, seed)
    scene = Scene(named_detector(camera.detector), camera.preset or PRESET, seed)
    return CameraReporter(camera, scene, seed)


def watch_camera(
    camera: Camera, seed: int, origin: float, target: KnownTarget | None, line: ReportLine
) -> None:
    """Watch a camera until it ends, and send a report of each frame.

    Parameters
    ----------
    camera
        The camera.
    seed
        Seed of the random numbers.
    origin
        The reading of `time.monotonic` at time 0 of live frames.
    target
        The known target for which it waits, in place of all objects.
    line
        To the place where reports meet.

    Raises
    ------
    BrokenPipeError
        If there is no receiver of messages any more.
    """
    frames, dropped, failure = 0, 0, None

    def report(frame: Frame, arrivals: Sequence[Arrival]) -> None:
        reporter.expect(arrivals)
        line.send(reporter.report(frame))

    try:
        reporter = reporter_of(camera, seed, target)
        with open_watched(camera.source, origin, camera.fps) as film:
            line.send(CameraReady(camera.name, isinstance(film, Live)))
            if isinstance(film, Source) and film.report.assumption is not None:
                line.send(CameraMessage(camera.name, film.report.assumption))
            if isinstance(film, Live):
                for news in film:
                    if isinstance(news, str):
                        line.send(CameraMessage(camera.name, news))
                        continue
                    report(news, line.arrivals())
                    frames, dropped = frames + 1, film.dropped
            else:
                # The next frame is announced before the work on one begins, so that it is always
                # known how far the other cameras may go.
                last: tuple[Frame, Go] | None = None
                for each in film:
                    frame = Frame(each.index, each.time + camera.offset, each.pixels)
                    line.send(NextFrame(frame.time))
                    if last is not None:
                        report(last[0], last[1].arrivals)
                        frames += 1
                    last = frame, line.go()
                if last is not None:
                    report(last[0], last[1].arrivals)
                    frames += 1
    except MotesError as error:
        failure = str(error)
    except BrokenPipeError:
        raise
    except Exception as error:  # a failure of one camera ends no other
        failure = f"{type(error).__name__}: {error}"
    line.send(CameraEnded(camera.name, frames, dropped, failure))
