"""How long a scene takes over a frame with thousands of detections.

    python benchmarks/many.py

A third of the detections are of objects, in a grid that fills a frame of 1920x1080 however many
there are; a third are doubles of these; a third is clutter at random places, from which few objects
are born. A tenth of the objects is not detected for half of the time. Milliseconds are those of the
processor, medians over the frames after the births. The objects' own time is that of what each does
by itself: it begins, predicts, is put where it is detected, observes with its filter, extrapolates.
All else is association: duplicates, distances and assignment, occlusion, reidentification,
initiation and termination.
"""

from __future__ import annotations

import time
from typing import Any

import numpy as np

from motes.core.detection import Detection
from motes.core.frame import Frame
from motes.core.geometry import Box
from motes.mot.scene import Scene
from motes.mot.tracked_object import TrackedObject
from motes_lab.report import markdown
from motes_lab.report.tables import Cell, Row, Table, number

SIZE = 1920, 1080
COUNTS = 100, 300, 1000, 3000
BIRTHS, FRAMES = 6, 18
"""Frames before any is timed, and all of them."""
OWN = "begin", "predict", "detect", "update_velocity", "observe", "extrapolate"

own = 0.0
"""Seconds of the processor that objects have taken."""


def clock(name: str) -> None:
    """Let a method of all objects add its time."""
    method = getattr(TrackedObject, name)

    def timed(*arguments: Any, **named: Any) -> Any:
        global own
        start = time.process_time()
        result = method(*arguments, **named)
        own += time.process_time() - start
        return result

    setattr(TrackedObject, name, staticmethod(timed) if name == "begin" else timed)


def detections(index: int, count: int) -> list[Detection]:
    """Return the detections of a frame, about so many, the same every time."""
    rng, objects = np.random.default_rng(index), count // 3
    across = int(np.ceil((objects * SIZE[0] / SIZE[1]) ** 0.5))
    pitch = SIZE[0] / across
    places = np.stack([np.arange(objects) % across, np.arange(objects) // across], axis=1) + 0.2
    sizes = np.full((objects, 2), 0.6 * pitch)
    shown = (np.arange(objects) % 10 > 0) | (index % 12 < 6)
    seen = np.hstack([places * pitch + rng.normal(0, 0.01 * pitch, sizes.shape), sizes])[shown]
    doubles = seen + rng.normal(0, 0.02 * pitch, seen.shape)
    clutter = np.hstack([rng.uniform(0, 1, sizes.shape) * SIZE, sizes])
    scores = rng.uniform(np.repeat([0.8, 0.6, 0.0], [len(seen), len(seen), objects]), 1)
    boxes = np.concatenate([seen, doubles, clutter]).tolist()
    return [Detection(Box(*box), score) for box, score in zip(boxes, scores.tolist(), strict=True)]


def measure(count: int) -> tuple[float, float, float]:
    """Return the median number of objects, and the milliseconds of association and of objects."""
    pixels = np.random.default_rng(0).integers(0, 256, (*SIZE[::-1], 3), np.uint8)
    found, rows = list[Detection](), []
    scene = Scene(lambda _: found)
    for index in range(FRAMES):
        found = detections(index, count)
        start, before = time.process_time(), own
        objects = len(scene.update(Frame(index, index / 25, pixels)))
        spent, theirs = time.process_time() - start, own - before
        rows.append((objects, (spent - theirs) * 1000, theirs * 1000))
    objects, rest, theirs = np.median(rows[BIRTHS:], axis=0).tolist()
    return objects, rest, theirs


def main() -> None:
    """Print a table."""
    for name in OWN:
        clock(name)
    measure(COUNTS[0])  # imports, and kernels from the cache
    rows: list[Row] = []
    for count in COUNTS:
        objects, rest, theirs = measure(count)
        cells = number(rest, 1), number(theirs, 0), number(rest + theirs, 0)
        rows.append((Cell(f"{count:,}"), Cell(f"{objects:,.0f}"), *cells))
    head = "detections", "objects", "association, ms", "objects' own, ms", "whole frame, ms"
    print(markdown.table(Table("A frame with thousands of detections", head, rows)))


if __name__ == "__main__":
    main()
