"""`motes track` with several objects: one run, a row for each of them in each frame."""

from __future__ import annotations

import time
from collections.abc import Generator, Iterator, Sequence
from pathlib import Path

from motes.cli.exit_codes import DONE
from motes.cli.frame_loop import run
from motes.cli.options import log
from motes.cli.watch_outputs import Form, FrameResult, Output, Overlay, objects_output
from motes.core import interrupts
from motes.core.errors import MotesError
from motes.core.frame import Frame
from motes.core.track import Status
from motes.mot.analytics.events import Regions
from motes.mot.tracked_object import SceneTrack
from motes.sot.batch import Trackers
from motes.video.sources import Source


def open_outputs(
    film: Source,
    stride: int,
    output: str | None,
    form: Form | None,
    label: str | None,
    overlay: Path | None,
    *,
    overwrite: bool,
) -> list[Output]:
    """Return what is to be written, after checks that it can be."""
    outputs: list[Output] = []
    if overlay is not None:
        outputs.append(Overlay(overlay, film, stride, Regions(), overwrite=overwrite))
    if output is not None:
        outputs.append(objects_output(output, film, overwrite=overwrite, form=form, label=label))
    return outputs


def track_several(
    film: Source,
    trackers: Trackers,
    regions: Sequence[Sequence[float]],
    outputs: Sequence[Output],
) -> int:
    """Follow the objects in regions of the first frame; their identities count from 1."""
    tally = Tally(len(regions))

    def moments(frames: Iterator[Frame]) -> Generator[FrameResult, None, None]:
        for frame in frames:
            clock = time.perf_counter()
            tracks = trackers.update(frame) if trackers.each else trackers.init(frame, regions)
            tally.seconds(time.perf_counter() - clock)
            each = [SceneTrack(i, track) for i, track in enumerate(tracks, start=1)]
            yield FrameResult(frame, each, ())

    try:
        interrupted = run(film, outputs, moments, tally.add)
    except MotesError:
        _summarize(tally, film, outputs, interrupted=None)
        raise
    _summarize(tally, film, outputs, interrupted=interrupted)
    return interrupts.code(interrupted) if interrupted else DONE


class Tally:
    """What there is to say about a run with so many objects."""

    def __init__(self, objects: int) -> None:
        self.frames = 0
        self._tracked = [0] * objects
        self._seconds = 0.0

    def seconds(self, seconds: float) -> None:
        """Count the time that a frame takes; the first one takes long and says nothing."""
        self._seconds += seconds if self.frames else 0.0

    def add(self, moment: FrameResult) -> str:
        """Count a frame; return how things are now."""
        seen = [each.track.status is Status.TRACKING for each in moment.tracks]
        self.frames += 1
        self._tracked = [count + here for count, here in zip(self._tracked, seen, strict=True)]
        return f"{sum(seen)} of {len(seen)} tracked"

    def __str__(self) -> str:
        parts = ["1 frame" if self.frames == 1 else f"{self.frames} frames"]
        parts += [
            f"object {i} tracked in {100 * count / self.frames:.1f} %"
            for i, count in enumerate(self._tracked, start=1)
        ]
        if self.frames > 1:
            parts.append(f"trackers {1000 * self._seconds / (self.frames - 1):.2f} ms a frame")
        return ", ".join(parts)


def _summarize(
    tally: Tally, film: Source, outputs: Sequence[Output], *, interrupted: KeyboardInterrupt | None
) -> None:
    """Print one line on how a run went."""
    if not tally.frames:
        return
    parts = [interrupts.word(interrupted) + str(tally)]
    written = [output.result for output in outputs if output.result is not None]
    if written:
        parts.append("wrote " + ", ".join(written))
    if film.report.problems:
        parts.append(f"{film.name}: {film.report.problems}")
    log("; ".join(parts) + ".")
