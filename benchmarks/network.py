"""Time and memory of a trained network in the default tracker, beside OpenCV's TrackerNano.

    python benchmarks/network.py BACKBONE HEAD SEQUENCES [--first-pixel 'seg-*=0' ...]

First on sequences, one object each; then 1, 4 and 16 objects in a rendered film of 640x480. All
take turns on the same BGR frames, each with one thread. A time is that of the processor, the median
over updates of a frame, all objects together. Memory is the largest of a process that follows the
objects, less that of one that has only imported what it needs; read as Linux tells it.
"""

from __future__ import annotations

import argparse
import importlib
import json
import re
import subprocess
import sys
import time
from collections.abc import Callable, Iterable, Sequence
from itertools import islice
from pathlib import Path
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from motes import OpenCVTracker
from motes.video.sources import open_source
from motes_lab.datasets.sot import load_dataset
from motes_lab.report import markdown
from motes_lab.report.tables import Cell, Row, Table, number

cv2: Any = importlib.import_module("cv2")
Images: TypeAlias = list[NDArray[np.uint8]]
KINDS = "default", "with the network", "TrackerNano"
COUNTS = 1, 4, 16
SIDE, PITCH, LENGTH, FRAMES = 60, 150, 40, 120
"""Side of the rendered objects and the distance of their places, and the lengths of films."""


def maker(kind: str, files: Sequence[str]) -> Callable[[], Any]:
    """Return what makes a tracker of a kind."""
    if kind != "TrackerNano":
        network = files if kind == "with the network" else ()
        return lambda: OpenCVTracker(network=network)
    parameters = cv2.TrackerNano_Params()
    parameters.backbone, parameters.neckhead = files
    return lambda: cv2.TrackerNano_create(parameters)


def rendered(count: int) -> tuple[Images, list[tuple[int, ...]]]:
    """Return frames with objects that move to the right, and their first boxes."""
    rng = np.random.default_rng(0)

    def texture(height: int, width: int) -> NDArray[np.uint8]:
        coarse = rng.integers(0, 256, (height // 12 + 1, width // 12 + 1, 3), np.uint8)
        whole: NDArray[np.uint8] = cv2.resize(coarse, (width, height))
        return whole

    ground = texture(480, 640) // 2 + 64
    looks = [texture(SIDE, SIDE) for _ in range(count)]
    places = [(15 + PITCH * (i % 4), 5 + 120 * (i // 4)) for i in range(count)]
    images = []
    for index in range(LENGTH):
        image = ground.copy()
        for (x, y), look in zip(places, looks, strict=True):
            image[y : y + SIDE, x + index : x + index + SIDE] = look
        images.append(image)
    return images, [(x, y, SIDE, SIDE) for x, y in places]


def milliseconds(
    images: Images, boxes: Sequence[Sequence[int]], files: Sequence[str]
) -> NDArray[np.float64]:
    """Return the median times of a frame, of all kinds in turn."""
    groups = [[make() for _ in boxes] for make in (maker(kind, files) for kind in KINDS)]
    for group in groups:
        for tracker, box in zip(group, boxes, strict=True):
            tracker.init(images[0], box)
    seconds = np.empty((len(images) - 1, len(KINDS)))
    for index, image in enumerate(images[1:]):
        for turn in range(len(KINDS)):
            which = (index + turn) % len(KINDS)
            start = time.process_time()
            for tracker in groups[which]:
                tracker.update(image)
            seconds[index, which] = time.process_time() - start
    return 1e3 * np.median(seconds, axis=0)


def megabytes(kind: str, count: int, files: Sequence[str]) -> float:
    """Return the largest memory of a process that follows objects; none with a count of 0."""
    words = [sys.executable, __file__, *files, "-", "--memory", json.dumps([kind, count])]
    return float(subprocess.run(words, capture_output=True, check=True, text=True).stdout)


def follow(kind: str, count: int, files: Sequence[str]) -> None:
    """Follow rendered objects, and print the largest memory of the process in MB."""
    images, boxes = rendered(COUNTS[-1])
    trackers = [maker(kind, files)() for _ in range(count)]
    for tracker, box in zip(trackers, boxes, strict=False):
        tracker.init(images[0], box)
    for image in images[1:] if count else ():
        for tracker in trackers:
            tracker.update(image)
    largest = re.search(r"VmHWM:\s+(\d+) kB", Path("/proc/self/status").read_text())
    assert largest is not None
    print(int(largest[1]) / 1024)


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("files", nargs=2)
    parser.add_argument("sequences", type=Path)
    parser.add_argument("--first-pixel", nargs="*", default=[])
    parser.add_argument("--memory", type=json.loads)
    options = parser.parse_args()
    cv2.setNumThreads(1)
    if options.memory:
        kind, count = options.memory
        follow(kind, count, options.files)
        return
    first = {glob: int(pixel) for glob, pixel in (v.rsplit("=", 1) for v in options.first_pixel)}
    sequences, problems = load_dataset(options.sequences, first)
    assert not problems, problems
    rows = []
    for sequence in sequences:
        with open_source(sequence.source) as source:
            frames = list(islice(source, min(FRAMES, sequence.frames)))
        images = [np.ascontiguousarray(frame.pixels[:, :, ::-1]) for frame in frames]
        box = [round(float(value)) for value in sequence.boxes[0]]
        rows.append(milliseconds(images, [box], options.files))
    times = np.array(rows)
    ratios = np.median(times / times[:, -1:], axis=0)
    lines: list[Row] = [
        row(f"{len(rows)} films, median", np.median(times, axis=0), 1),
        row("films, median in TrackerNano's", ratios, 2),
    ]
    for count in COUNTS:
        took = milliseconds(*rendered(count), options.files)
        more = [
            megabytes(kind, count, options.files) - megabytes(kind, 0, options.files)
            for kind in KINDS
        ]
        lines += [row(f"rendered, {count} at once", took, 1), row(f"{count} at once, MB", more, 0)]
    head = "ms of the processor a frame, or MB", *KINDS
    print(markdown.table(Table("What a trained network takes", head, lines)))


def row(name: str, values: Iterable[float], digits: int) -> Row:
    """Return a row of the table."""
    return Cell(name), *(number(value, digits) for value in values)


if __name__ == "__main__":
    main()
