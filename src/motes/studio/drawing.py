"""What a session draws: annotated films, figures of the papers, slit scans, the foreground."""

from __future__ import annotations

import io
import time
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path

import numpy as np
from PIL import Image

from motes.core.frame import FRAME_INTERVAL, Frame
from motes.core.geometry import Ellipse
from motes.core.track import Status, Track
from motes.correction.passes import run_pass
from motes.mot.analytics.regions import Line, Regions
from motes.mot.detection.background import BackgroundDetector
from motes.mot.detection.background_models import Method
from motes.mot.tracked_object import SceneTrack
from motes.output.figures import Recorder
from motes.output.overlay import draw
from motes.output.painters import TRAIL, ScenePainter
from motes.output.slit_scan import SlitScan
from motes.sot.step_info import StepInfo
from motes.studio.plan import RunPass
from motes.studio.tables import Table, tracks
from motes.studio.workplace import Workplace
from motes.video.writer import VideoWriter

Crossing = tuple[int, float, float, int, bool]
"""A crossing of a line: its frame, the place of the foot, the identity, and whether it goes to the
second side."""

BEFORE = 75
"""Frames from which the background is learned: three seconds of most films."""


def annotated(place: Workplace, tables: Mapping[int, Table], path: str) -> bytes:
    """Write a film with the objects drawn: one object as `motes track --overlay` does.

    Several objects are drawn with their numbers, as `motes watch --overlay` does.
    """
    film, found = place.film, {number: tracks(table) for number, table in tables.items()}
    first = min(shown[0].frame for shown in found.values())
    last = max(shown[-1].frame for shown in found.values())
    by_frame: dict[int, list[SceneTrack]] = {}
    for number, shown in found.items():
        for track in shown:
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
            place.check()
    return b""


def _one(frame: Frame, track: Track, trail: list[tuple[float, float]]) -> np.ndarray:
    seen = track.status is Status.TRACKING
    trail.append(track.ellipse[:2] if seen else (np.nan, np.nan))
    del trail[:-TRAIL]
    return draw(
        frame.pixels, track, particles=np.empty((0, 5)), weights=np.empty(0), trail=[*trail]
    )


def figures(place: Workplace, run: RunPass, path: str) -> bytes:
    """Draw the figures of the papers for a pass into a folder, as `motes track --figures`."""
    recorder = Recorder(run.config)
    clock, kept = 0.0, list[Frame]()

    def frames() -> Iterator[Frame]:
        nonlocal clock
        for frame in place.film.forward(run.start, run.stop):
            kept[:] = [frame]
            clock = time.perf_counter()
            yield frame

    def observe(info: StepInfo) -> None:
        recorder.add(kept[0], info, time.perf_counter() - clock, None)
        place.check()

    run_pass(run.config, run.seed, frames(), Ellipse(*run.region), observe=observe)
    recorder.save(Path(path))
    return b""


def slit(place: Workplace, line: Line, crossings: Sequence[Crossing]) -> bytes:
    """Return the slit scan of a line as PNG, as `motes watch --slit` makes it."""
    scan = SlitScan(line.points, line.label)
    for frame in place.film.forward(0, len(place.film.times) - 1):
        scan.add(frame.pixels, frame.index, frame.time)
        place.check()
    for index, x, y, identity, second in crossings:
        scan.mark(index, (x, y), identity, second=second)
    out = io.BytesIO()
    Image.fromarray(scan.picture()).save(out, "PNG")
    return out.getvalue()


def foreground(place: Workplace, method: Method, index: int) -> bytes:
    """Return a PNG of the moving pixels of a frame: white, the others transparent."""
    film, detector = place.film, BackgroundDetector(method)
    detector.prepare(film.forward(0, len(film.times) - 1))
    for frame in film.forward(max(0, index - BEFORE), index):
        detector(frame)
        place.check()
    moving = np.zeros((film.height, film.width), bool)
    if detector.mask is not None:
        moving |= detector.mask > 0
    pixels = np.where(moving[:, :, None], np.uint8(255), np.uint8(0)).repeat(4, axis=2)
    out = io.BytesIO()
    Image.fromarray(pixels, "RGBA").save(out, "PNG")
    return out.getvalue()
