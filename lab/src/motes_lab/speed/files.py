"""Frames of video files in a second: only decoded, and followed."""

from __future__ import annotations

import itertools
import time
from collections.abc import Sequence
from functools import partial
from pathlib import Path

from motes.core.frame import FRAME_INTERVAL
from motes.core.geometry import Ellipse
from motes.sot.batch import Trackers
from motes.video.prefetch import prefetch
from motes.video.sources import open_source
from motes.video.writer import VideoWriter
from motes_lab.speed.measure import Film, Run, quick_start_config


def jobs(folder: Path, name: str, film: Film, targets: int, length: int) -> dict[str, Run]:
    """Write a file in which a film is repeated; return its runs, "decoded" and "followed".

    The times that they return are the mean for a frame.
    """
    path = folder / f"{name}.mp4"
    with VideoWriter(path, 1 / FRAME_INTERVAL) as writer:
        for frame in itertools.islice(itertools.cycle(film.frames), length):
            writer.write(frame.pixels)
    return {
        "decoded": partial(_decode, path),
        "followed": partial(_follow, path, film.regions[:targets]),
    }


def _decode(path: Path) -> list[float]:
    start = time.perf_counter()
    with open_source(path) as source:
        count = sum(1 for _ in source)
    return [(time.perf_counter() - start) / count]


def _follow(path: Path, regions: Sequence[Ellipse]) -> list[float]:
    """Follow regions, while a thread decodes ahead as in `motes track`."""
    start = time.perf_counter()
    with open_source(path) as source, prefetch(source) as frames:
        trackers = Trackers(quick_start_config())
        trackers.init(next(frames), regions)
        count = 1 + sum(1 for _ in map(trackers.update, frames))
    return [(time.perf_counter() - start) / count]
