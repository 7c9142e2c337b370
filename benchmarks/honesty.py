"""How honest the confidence of a tracker is: off the target, on it, and on the whole.

    python benchmarks/honesty.py FOLDER ... [--mot MOT_FOLDER] [--tracker default] [--seeds 4]

Each FOLDER holds sequences or films with their truth, whose first pixel is 0 in those that fit
`--zero`; all are followed for their first `FRAMES` frames. Of MOT_FOLDER, the people of
`walkers.py` are followed, forwards and backwards. A row has the share of the frames off the target
in which the tracker is sure, F1 of the lost status, the calibration error of the confidence, and
the share of the frames on the target in which it is not sure.
"""

from __future__ import annotations

import argparse
from collections.abc import Iterable, Iterator
from concurrent.futures import ProcessPoolExecutor
from functools import partial
from itertools import islice, product
from pathlib import Path
from typing import NamedTuple

import numpy as np

from motes.core.frame import Frame
from motes.core.geometry import Box, iou
from motes.core.types import Flags, Floats
from motes.video.sources import open_source
from motes_lab.adapters.registry import TrackerSpec, resolve
from motes_lab.datasets.mot import load_mot_dataset
from motes_lab.datasets.sot import load_dataset
from motes_lab.metrics.sot import calibration_error
from walkers import OFF, SURE, size, walkers

FRAMES = 150
"""Most frames of a sequence that are followed."""
ON = 0.5
"""A frame is on the target above this overlap."""


class Stretch(NamedTuple):
    """Frames of a film in which a target is followed."""

    source: str | Path
    first: int
    boxes: Floats
    """(frames, 4), the truth; NaN where the target is absent."""
    backward: bool = False


class Run(NamedTuple):
    """A tracker on a stretch: a number for each frame in which the target is there."""

    overlaps: Floats
    confidence: Floats
    lost: Flags


def sequences(folder: Path, zero: Iterable[str]) -> Iterator[Stretch]:
    """Yield the sequences of a folder."""
    names = [each.name for each in folder.iterdir()]
    fitting = {each: 0 for each in zero if any(Path(name).match(each) for name in names)}
    for each in load_dataset(folder, fitting)[0]:
        first = int(np.flatnonzero(~np.isnan(each.boxes[:, 0]))[0])
        yield Stretch(each.source, first, each.boxes[first : first + FRAMES])


def people(folder: Path) -> Iterator[Stretch]:
    """Yield the walkers of a folder of sequences with many objects."""
    for sequence in load_mot_dataset(folder)[0]:
        for each in walkers(sequence, *size(sequence)):
            for backward in (False, True):
                yield Stretch(sequence.source, each.first, each.boxes, backward)


def follow(task: tuple[Stretch, int], spec: TrackerSpec) -> Run:
    """Return a run: a stretch and a seed."""
    stretch, seed = task
    with open_source(stretch.source) as source:
        last = stretch.first + len(stretch.boxes)
        pictures = [frame.pixels for frame in islice(source, stretch.first, last)]
    boxes = stretch.boxes[: len(pictures)]
    if stretch.backward:
        pictures, boxes = pictures[::-1], boxes[::-1]
    tracker = spec.begin(seed)
    frames = [Frame(index, index / 25, each) for index, each in enumerate(pictures)]
    tracker.init(frames[0], Box(*boxes[0]))
    answers = [tracker.update(frame) for frame in frames[1:]]
    there = [not np.isnan(box[0]) for box in boxes[1:]]
    seen = [
        (0.0 if answer.ellipse is None else float(iou(answer.ellipse.box, box)), answer)
        for answer, box, shown in zip(answers, boxes[1:], there, strict=True)
        if shown
    ]
    return Run(
        np.array([overlap for overlap, _ in seen]),
        np.array([answer.confidence for _, answer in seen]),
        np.array([answer.lost for _, answer in seen]),
    )


def row(runs: list[Run]) -> str:
    """Return the columns of a table; in the calibration error, all runs count the same."""
    overlaps, confidence, lost = (np.concatenate(each) for each in zip(*runs, strict=True))
    weights = np.concatenate([np.full(len(run.overlaps), 1 / len(run.overlaps)) for run in runs])
    off, on, sure = overlaps < OFF, overlaps > ON, ~lost & (confidence > SURE)
    f1 = 2 * (lost & off).sum() / max(lost.sum() + off.sum(), 1)
    error = calibration_error(confidence, on, weights)
    unsure = 1 - sure[on].mean()
    return f"{off.mean():.1%} | {sure[off].mean():.0%} | {f1:.3f} | {error:.3f} | {unsure:.1%}"


def main() -> None:
    """Follow all targets and print a row for each folder and tracker."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("folders", nargs="*", type=Path)
    parser.add_argument("--mot", type=Path)
    parser.add_argument("--zero", nargs="*", default=["seg-*"])
    parser.add_argument("--tracker", nargs="*", default=["default"])
    parser.add_argument("--seeds", type=int, default=4)
    parser.add_argument("--workers", type=int, default=2)
    given = parser.parse_args()
    specs, unknown = resolve(given.tracker)
    for problem in unknown:
        print(problem)
    stretches = {folder: [*sequences(folder, given.zero)] for folder in given.folders}
    if given.mot is not None:
        stretches[given.mot] = [*people(given.mot)]
    print("| targets | tracker | off | sure, of these | F1 of lost | calibration error | unsure |")
    print("|---|---|---|---|---|---|---|")
    for (folder, each), spec in product(stretches.items(), specs):
        tasks = [*product(each, range(given.seeds if spec.stochastic else 1))]
        with ProcessPoolExecutor(given.workers) as pool:
            runs = [*pool.map(partial(follow, spec=spec), tasks)]
        print(f"| {folder.name} | {spec.name} | {row(runs)} |", flush=True)


if __name__ == "__main__":
    main()
