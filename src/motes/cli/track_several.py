"""`motes track` with several objects: one run, a row for each of them in each frame."""

from __future__ import annotations

import contextlib
import time
from collections.abc import Sequence
from pathlib import Path

from motes.cli import DONE, INTERRUPTED
from motes.cli.follow import prefetch
from motes.cli.options import announce_compiling, say, undisturbed
from motes.cli.progress import Progress
from motes.cli.watch_outputs import Form, Moment, Output, Overlay, objects_output
from motes.counting import Places
from motes.errors import MotesError
from motes.frame import Frame
from motes.objects import SceneTrack
from motes.track import Status
from motes.trackers import Trackers
from motes.video import Source


def open_outputs(
    film: Source,
    stride: int,
    output: str | None,
    form: Form | None,
    overlay: Path | None,
    *,
    overwrite: bool,
) -> list[Output]:
    """Return what is to be written, after checks that it can be."""
    outputs: list[Output] = []
    if overlay is not None:
        outputs.append(Overlay(overlay, film, stride, Places(), overwrite=overwrite))
    if output is not None:
        outputs.append(objects_output(output, overwrite, form))
    return outputs


def track_several(
    film: Source,
    trackers: Trackers,
    regions: Sequence[Sequence[float]],
    outputs: Sequence[Output],
) -> int:
    """Follow the objects in regions of the first frame; their identities count from 1."""
    announce_compiling()
    tally, interrupted = Tally(len(regions)), False

    def step(frame: Frame) -> Moment:
        tracks = trackers.update(frame) if trackers.each else trackers.init(frame, regions)
        return Moment(frame, [SceneTrack(i, each) for i, each in enumerate(tracks, start=1)], ())

    try:
        with contextlib.ExitStack() as opened, prefetch(film) as frames:
            for output in outputs:
                opened.enter_context(output)
            with Progress(film) as progress:
                try:
                    for frame in frames:
                        clock = time.perf_counter()
                        moment = step(frame)
                        seconds = time.perf_counter() - clock
                        with undisturbed():
                            for output in outputs:
                                output.write(moment)
                            tally.add(moment, seconds)
                        progress.count(tally.state)
                except KeyboardInterrupt:
                    interrupted = True  # and all files are closed as at the end
    except KeyboardInterrupt:
        interrupted = True
    except MotesError:
        _summarize(tally, film, outputs, interrupted=False)
        raise
    _summarize(tally, film, outputs, interrupted=interrupted)
    return INTERRUPTED if interrupted else DONE


class Tally:
    """What there is to say about a run with so many objects."""

    def __init__(self, objects: int) -> None:
        self.frames = 0
        self._tracked = [0] * objects
        self._now = 0
        self._seconds = 0.0

    def add(self, moment: Moment, seconds: float) -> None:
        """Count a frame."""
        seen = [each.track.status is Status.TRACKING for each in moment.tracks]
        self._seconds += seconds if self.frames else 0.0  # the first frame takes long
        self.frames += 1
        self._tracked = [count + here for count, here in zip(self._tracked, seen, strict=True)]
        self._now = sum(seen)

    @property
    def state(self) -> str:
        """How things are now."""
        return f"{self._now} of {len(self._tracked)} tracked"

    def __str__(self) -> str:
        parts = ["1 frame" if self.frames == 1 else f"{self.frames} frames"]
        parts += [
            f"object {i} tracked in {100 * count / self.frames:.1f} %"
            for i, count in enumerate(self._tracked, start=1)
        ]
        if self.frames > 1:
            parts.append(f"trackers {1000 * self._seconds / (self.frames - 1):.2f} ms a frame")
        return ", ".join(parts)


def _summarize(tally: Tally, film: Source, outputs: Sequence[Output], *, interrupted: bool) -> None:
    """Print one line on how a run went."""
    if not tally.frames:
        return
    parts = ["interrupted after " * interrupted + str(tally)]
    written = [output.name for output in outputs if output.name != "-"]
    if written:
        parts.append("wrote " + ", ".join(written))
    if film.report.problems:
        parts.append(f"{film.name}: {film.report.problems}")
    say("; ".join(parts) + ".")
