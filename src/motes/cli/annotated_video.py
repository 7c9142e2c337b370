"""What is drawn into the frames of a run, and the video of it."""

from __future__ import annotations

from collections import deque
from math import isfinite, nan
from pathlib import Path
from typing import Protocol, Self

from motes.cli.frame_loop import Moment, Sink
from motes.core.frame import FRAME_INTERVAL
from motes.core.track import ROUNDING, Status, Track
from motes.core.types import Bytes
from motes.mot.analytics.ground_plane import Point
from motes.mot.analytics.regions import Regions
from motes.output.overlay import describe, draw
from motes.output.scene_overlay import draw_scene
from motes.video.film import Film
from motes.video.sources import Source
from motes.video.writer import VideoWriter

TRAIL = 50
"""Frames of a trail."""
RESTS = 3.0
"""Standard deviations below which a speed may be 0."""
NOWHERE = (nan, nan)
"""In a trail, the place of a target that is not seen."""


class Painter(Protocol):
    """Paints the moments of a run, in their order."""

    def painted(self, moment: Moment) -> Bytes:
        """Return the picture of a moment with all that is drawn on it."""


class TargetPainter(Painter):
    """Paints one target, its particles and its trail, and its speed if that is in `metres`."""

    def __init__(self, *, metres: bool = False) -> None:
        self._metres = metres
        self._trail: deque[Point] = deque(maxlen=TRAIL)

    def painted(self, moment: Moment) -> Bytes:
        """Return the picture of a moment; nothing is drawn before there is a target."""
        pixels, info = moment.frame.pixels, moment.info
        if info is None:
            return pixels
        target = moment.target
        seen = target.status is Status.TRACKING
        self._trail.append(target.ellipse[:2] if seen else NOWHERE)
        speed = speed_label(target) if self._metres else ""
        label = describe(target, speed) if speed else None
        return draw(
            pixels, target, particles=info.ellipses, weights=info.weights, trail=self._trail,
            label=label,
        )  # fmt: skip


class ScenePainter(Painter):
    """Paints all objects with their trails and speeds, the lines and zones, the time and totals.

    A trail is of the point that is counted: the foot. It is interrupted where that is not seen.
    """

    def __init__(self, places: Regions) -> None:
        self._places, self._counted = places, sorted({*places.totals})
        self._trails: dict[int, deque[Point]] = {}

    def painted(self, moment: Moment) -> Bytes:
        """Return the picture of a moment, with the crossings, entries and exits so far."""
        frame, tracks, totals = moment.frame, moment.tracks, moment.totals
        # A detection without an identity has no past.
        here = {each.identity for each in tracks if each.identity > 0}
        self._trails = {
            identity: trail for identity, trail in self._trails.items() if identity in here
        }
        for each in (each for each in tracks if each.identity in here):
            trail = self._trails.setdefault(each.identity, deque(maxlen=TRAIL))
            trail.append(each.box.foot if each.status is Status.TRACKING else NOWHERE)
        minutes, seconds = divmod(int(frame.time), 60)
        passed = [f"{name} {totals[name]}" for name in self._counted if name in totals]
        caption = [f"{frame.index}  {minutes}:{seconds:02}", *passed]
        every = {each.identity: speed_label(each) for each in tracks}
        notes = {name: label for name, label in every.items() if label}
        return draw_scene(frame.pixels, tracks, self._trails, self._places, caption, notes)


def speed_label(track: Track) -> str:
    """Return a speed in metres a second as text; "" if it is not known.

    A microscope's are small; one that may be that of an object at rest is 0.00.
    """
    speed, deviation = track.number("speed"), track.number("speed_std")
    if not isfinite(speed):
        return ""
    small = max(ROUNDING, RESTS * deviation if isfinite(deviation) else 0.0) < speed < 0.1
    return f"{speed:.2g} m/s" if small else f"{speed:.2f} m/s"


class AnnotatedVideo(Sink):
    """A video that begins at 0; checks on construction that it can be written.

    Raises a FormatError if the file exists and must not be overwritten, or cannot be made. It has
    every n-th frame of the source, by `stride`.
    """

    def __init__(
        self, path: Path, source: Source | Film, painter: Painter, stride: int, *, overwrite: bool
    ) -> None:
        self._painter = painter
        self._writer = VideoWriter(path, (source.fps or 1 / FRAME_INTERVAL) / stride, overwrite)
        self._start: float | None = None

    def write(self, moment: Moment) -> None:
        """Add a picture, at the time of its frame."""
        time = moment.frame.time
        if self._start is None:
            self._start = time
        self._writer.write(self._painter.painted(moment), time - self._start)

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
