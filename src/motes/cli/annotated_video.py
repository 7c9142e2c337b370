"""What is drawn into the frames of a run: a video of it."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Self

from motes.cli.frame_loop import Moment, Sink
from motes.core.frame import FRAME_INTERVAL
from motes.core.types import Bytes
from motes.mot.analytics.regions import Regions
from motes.output.painters import ScenePainter, TargetPainter
from motes.video.film import Film
from motes.video.sources import Source
from motes.video.writer import VideoWriter

Paint = Callable[[Moment], Bytes]
"""Returns the picture of a moment; called with each of them, in order."""


def painted_scene(places: Regions) -> Paint:
    """Return what paints several objects, the time, and the crossings, entries and exits so far."""
    painter = ScenePainter(places)

    return lambda moment: painter.painted(moment.frame, moment.tracks, moment.totals)


def painted_target(*, metres: bool) -> Paint:
    """Return what paints one object, its particles and its trail, and its speed in metres."""
    painter = TargetPainter(metres=metres)

    def painted(moment: Moment) -> Bytes:
        info = moment.info
        if info is None:
            return moment.frame.pixels
        return painter.painted(moment.frame, moment.target, info.ellipses, info.weights)

    return painted


class AnnotatedVideo(Sink):
    """A video that begins at 0; checks on construction that it can be written.

    Raises a FormatError if the file exists and must not be overwritten, or cannot be made. It has
    every n-th frame of the source, by `stride`.
    """

    def __init__(
        self, path: Path, source: Source | Film, stride: int, painted: Paint, *, overwrite: bool
    ) -> None:
        self._painted = painted
        self._writer = VideoWriter(path, (source.fps or 1 / FRAME_INTERVAL) / stride, overwrite)
        self._start: float | None = None

    def write(self, moment: Moment) -> None:
        """Add a picture, at the time of its frame."""
        time = moment.frame.time
        if self._start is None:
            self._start = time
        self._writer.write(self._painted(moment), time - self._start)

    @property
    def result(self) -> str | None:
        """The video, or the unfinished file that an error left; None for nothing."""
        writer = self._writer
        if writer.result is None:
            return None
        return f"{writer.result}" + " (unfinished)" * (writer.result != writer.path)

    def __enter__(self) -> Self:
        self._writer.__enter__()
        return self

    def __exit__(self, *exception: object) -> None:
        """Close the video; one that Ctrl-C ended is complete up to its last frame."""
        self._writer.__exit__(*exception)  # type: ignore[arg-type]
