"""What a session draws: annotated films, the papers' figures, and slit scans."""

from __future__ import annotations

import io
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from pathlib import Path

import numpy as np
from PIL import Image

from motes.core.frame import FRAME_INTERVAL, Frame
from motes.core.geometry import Ellipse
from motes.core.track import Status, Track
from motes.correction.passes import run_pass
from motes.mot.analytics.regions import Regions
from motes.mot.tracked_object import SceneTrack
from motes.output.figures import Recorder
from motes.output.overlay import draw
from motes.output.painters import TRAIL, ScenePainter
from motes.output.slit_scan import SlitScan
from motes.sot.presets import TrackerConfig
from motes.sot.step_info import StepInfo
from motes.studio.tasks import DrawFigures, DrawSlit
from motes.video.film import Film
from motes.video.writer import VideoWriter

Check = Callable[[], None]
"""Called now and then, to be stopped and to show that the work goes on."""


def annotated(film: Film, found: Mapping[int, Sequence[Track]], path: str, check: Check) -> None:
    """Write a film with the objects drawn: one object as `motes track --overlay` does.

    Several objects are drawn with their numbers, as `motes watch --overlay` does.
    """
    first = min(tracks[0].frame for tracks in found.values())
    last = max(tracks[-1].frame for tracks in found.values())
    by_frame: dict[int, list[SceneTrack]] = {}
    for number, tracks in found.items():
        for track in tracks:
            if track.status is not Status.ABSENT or len(found) == 1:
                by_frame.setdefault(track.frame, []).append(SceneTrack(number, track))
    scene, trail = ScenePainter(Regions()), list[tuple[float, float]]()
    with VideoWriter(path, film.fps or 1 / FRAME_INTERVAL) as writer:
        for frame in film.forward(first, last):
            here = by_frame.get(frame.index, [])
            if len(found) > 1:
                pixels = scene.painted(frame, here, ())()
            else:
                pixels = _one(frame, here[0].track, trail)
            writer.write(pixels, frame.time - film.times[first])
            check()


def _one(frame: Frame, track: Track, trail: list[tuple[float, float]]) -> np.ndarray:
    seen = track.status is Status.TRACKING
    trail.append(track.ellipse[:2] if seen else (np.nan, np.nan))
    del trail[:-TRAIL]
    return draw(
        frame.pixels, track, particles=np.empty((0, 5)), weights=np.empty(0), trail=[*trail]
    )


def figures(film: Film, config: TrackerConfig, task: DrawFigures, check: Check) -> None:
    """Draw the figures of the papers for a pass into the folder of a task."""
    recorder = Recorder(config)
    clock, kept = 0.0, list[Frame]()

    def frames() -> Iterator[Frame]:
        nonlocal clock
        for frame in film.forward(task.start, task.stop):
            kept[:] = [frame]
            clock = time.perf_counter()
            yield frame

    def observe(info: StepInfo) -> None:
        recorder.add(kept[0], info, time.perf_counter() - clock, None)
        check()

    run_pass(config, task.seed, frames(), Ellipse(*task.region), observe=observe)
    recorder.save(Path(task.path))


def slit(film: Film, task: DrawSlit, check: Check) -> bytes:
    """Return the slit scan of a line as PNG, as `motes watch --slit` makes it."""
    scan = SlitScan(task.line, task.label)
    for frame in film.forward(0, len(film.times) - 1):
        scan.add(frame.pixels, frame.index, frame.time)
        check()
    for index, x, y, identity, second in task.crossings:
        scan.mark(index, (x, y), identity, second=second)
    out = io.BytesIO()
    Image.fromarray(scan.picture()).save(out, "PNG")
    return out.getvalue()
