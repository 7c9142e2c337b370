"""How many frames a second a scene of many objects takes, and what of it is detection.

    python benchmarks/scene.py

Twenty rendered targets at 640x480 that circle around their places, and a hundred smaller ones. They
are detected from the truth, so that all of them are there, but `BackgroundDetector` looks at each
frame as well and takes its time. Milliseconds are the processor's, those of all threads together;
frames a second are of the clock, from a frame in memory to what is said of it, in a process that
has one core or two, with detection in turn with tracking or ahead of it. Then tracking alone, of as
many targets as there is room for in larger frames. Medians of `RUNS` processes.
"""

from __future__ import annotations

import itertools
import multiprocessing
import os
import time
from collections.abc import Iterator

import numpy as np

from motes import synthetic
from motes.core.detection import Detection
from motes.core.frame import Frame
from motes.mot.detection.background import BackgroundDetector
from motes.mot.scene import Scene
from motes_lab.report import markdown
from motes_lab.report.tables import Cell, Row, Table, number

SIZE, TARGET = (640, 480), (60, 80)
TARGETS = {20: TARGET, 104: (24, 38)}
"""Number of objects in a frame, and their size."""
SIZES = SIZE, (1280, 720), (1920, 1080)
LAPS = 8
WARM = 40
"""Frames before any is timed: births, and imports."""
RUNS = 3


class Film:
    """The rendered frames again and again, and the detector that takes its time over them."""

    def __init__(self, objects: int) -> None:
        clip = synthetic.crowd(SIZE, TARGETS[objects])
        assert len(clip.targets) == objects
        self._pictures = [frame.pixels for frame, _ in clip]
        self._truths = [[Detection(truth.ellipse.box) for truth in truths] for _, truths in clip]
        self._background = BackgroundDetector()

    def __iter__(self) -> Iterator[Frame]:
        for index in range(LAPS * len(self._pictures)):
            yield Frame(index, index / 25, self._pictures[index % len(self._pictures)])

    def detect(self, frame: Frame) -> list[Detection]:
        """Return the truth, after a look at the frame."""
        self._background(frame)
        return self._truths[frame.index % len(self._truths)]


def cost(objects: int) -> tuple[float, float]:
    """Return the milliseconds of the processor that detection and tracking take of a frame."""
    film, found, spent = Film(objects), list[Detection](), []
    scene = Scene(lambda _: found)
    for frame in film:
        start = time.process_time()
        found = film.detect(frame)
        between = time.process_time()
        said = scene.update(frame)
        spent.append((between - start, time.process_time() - between))
    assert len(said) == objects
    detection, tracking = np.median(spent[WARM:], axis=0) * 1000
    return float(detection), float(tracking)


def rate(objects: int, cores: int, ahead: bool) -> float:
    """Return frames a second on so many cores."""
    os.sched_setaffinity(0, sorted(os.sched_getaffinity(0))[:cores])  # before OpenCV's threads
    film = Film(objects)
    for frame, said in Scene(film.detect).watch(film, ahead=ahead):
        if frame.index == WARM:
            assert len(said) == objects
            start = time.perf_counter()
    return (frame.index - WARM) / (time.perf_counter() - start)


def tracking(size: tuple[int, int]) -> tuple[int, float]:
    """Return how many objects have room in a frame, and the milliseconds that following takes."""
    found, spent = list[Detection](), []
    scene = Scene(lambda _: found)
    clip = list(synthetic.crowd(size, TARGET))
    for index in range(WARM + 4 * len(clip)):
        picture, truths = clip[index % len(clip)]
        found = [Detection(truth.ellipse.box) for truth in truths]
        frame = Frame(index, index / 25, picture.pixels)
        start = time.process_time()
        said = scene.update(frame)
        spent.append(time.process_time() - start)
    assert len(said) == len(clip[0][1])
    return len(said), float(np.median(spent[WARM:])) * 1000


def main() -> None:
    """Print three tables."""
    context = multiprocessing.get_context("spawn")
    with context.Pool(1, maxtasksperchild=1) as pool:
        rows: list[Row] = []
        for objects in TARGETS:
            costs = [pool.apply(cost, (objects,)) for _ in range(RUNS)]
            detection, followed = np.median(costs, axis=0).tolist()
            times = detection, followed, detection + followed
            rows.append((Cell(f"{objects}"), *(number(each, 1) for each in times)))
        head: tuple[str, ...] = "objects", "detection, ms of processor", "tracking", "both"
        print(markdown.table(Table("A scene: detection and tracking", head, rows)), end="\n\n")
        rows = []
        for objects, cores in itertools.product(TARGETS, (1, 2)):
            rates = [
                float(np.median([pool.apply(rate, (objects, cores, ahead)) for _ in range(RUNS)]))
                for ahead in (False, True)
            ]
            numbers = (number(each, 0) for each in rates)
            rows.append((Cell(f"{objects}"), Cell(f"{cores}"), *numbers))
        head = "objects", "cores", "in turn, frames a second", "ahead, frames a second"
        print(markdown.table(Table("A scene: frames a second", head, rows)), end="\n\n")
        rows = []
        for size in SIZES:
            runs = [pool.apply(tracking, (size,)) for _ in range(RUNS)]
            count, spent = np.median(runs, axis=0).tolist()
            rows.append((number(count, 0), number(spent, 1), number(spent / count, 2)))
        head = "objects", "tracking, ms of processor", "for each"
        print(markdown.table(Table("A scene: tracking alone", head, rows)))


if __name__ == "__main__":
    main()
