"""Walkers in crowds, each followed alone: how many runs end on the right person.

    python benchmarks/walkers.py MOT_FOLDER [--tracker default ...] [--seeds 8] [--workers 2]

A walker is an identity of the truth that is wholly in the picture for `LEAST` frames in a row; the
first `MOST` of its longest such stretch are followed, forwards and backwards. Crowds are chaotic:
one exchange for a neighbor decides the rest of a run, so single mean overlaps say little. The
interval of a mean is that over walkers (95 %), each the mean of its runs.
"""

from __future__ import annotations

import argparse
from collections.abc import Iterator
from concurrent.futures import ProcessPoolExecutor
from functools import partial
from itertools import product
from pathlib import Path
from typing import NamedTuple

import numpy as np

from motes.core.frame import Frame
from motes.core.geometry import Box, iou
from motes.core.types import Floats
from motes.video.sources import open_source
from motes_lab.adapters.registry import TrackerSpec, resolve
from motes_lab.datasets.mot import MotSequence, load_mot_dataset

LEAST, MOST = 40, 140
"""Fewest frames in which a walker is wholly seen, and most that are followed."""
LAST, RIGHT = 10, 0.3
"""A run ends on the right person if most of its last frames overlap the truth by so much."""
OFF, SURE = 0.1, 0.5
"""A frame is off the target below this overlap; a tracker is sure above this confidence."""


class Walker(NamedTuple):
    """A person who is followed."""

    sequence: MotSequence
    first: int
    """The first frame, from 0."""
    boxes: Floats
    """(frames, 4), the truth from there on: x, y, width, height; the first pixel is 0."""


class Score(NamedTuple):
    """What is measured in a run; the means of all runs are printed."""

    right: float
    """Whether it ends on the right person."""
    overlap: float
    off: float
    """Share of the frames that are off the target."""
    sure: float
    """Share of the frames that are off the target, tracked, and with a confidence above `SURE`."""


def walkers(sequence: MotSequence, width: int, height: int) -> Iterator[Walker]:
    """Yield the walkers of a sequence whose pictures have this size."""
    truth = sequence.truth
    boxes = truth.boxes - (1, 1, 0, 0)
    ends = boxes[:, :2] + boxes[:, 2:]
    whole = (boxes[:, :2] >= 0).all(axis=1) & (ends <= (width + 1, height + 1)).all(axis=1)
    for identity in np.unique(truth.ids):
        rows = np.flatnonzero((truth.ids == identity) & whole)
        stretches = np.split(rows, np.flatnonzero(np.diff(truth.frames[rows]) != 1) + 1)
        longest = max(stretches, key=len)
        if len(longest) >= LEAST:
            yield Walker(sequence, int(truth.frames[longest[0]]) - 1, boxes[longest[:MOST]])


def score(task: tuple[Walker, bool, int], spec: TrackerSpec) -> Score:
    """Return the score of a run: a walker, whether backward, and a seed."""
    walker, backward, seed = task
    with open_source(walker.sequence.source) as source:
        frames = [frame.pixels for frame in source][walker.first :][: len(walker.boxes)]
    boxes = walker.boxes
    if backward:
        frames, boxes = frames[::-1], boxes[::-1]
    tracker = spec.begin(seed)
    pictures = [
        Frame(index, index / walker.sequence.rate, each) for index, each in enumerate(frames)
    ]
    tracker.init(pictures[0], Box(*boxes[0]))
    overlaps, sure = [], []
    for picture, box in zip(pictures[1:], boxes[1:], strict=True):
        answer = tracker.update(picture)
        found = None if answer.ellipse is None else answer.ellipse.box
        overlaps.append(0.0 if found is None else float(iou(found, Box(*box))))
        sure.append(not answer.lost and not answer.confidence <= SURE)  # NaN: it says nothing
    overlap, off = np.array(overlaps), np.array(overlaps) < OFF
    right = np.mean(overlap[-LAST:] > RIGHT) > 0.5
    return Score(float(right), overlap.mean(), off.mean(), float((off & np.array(sure)).mean()))


def size(sequence: MotSequence) -> tuple[int, int]:
    """Return the width and height of a sequence's pictures."""
    with open_source(sequence.source) as source:
        first = next(iter(source))
    return first.width, first.height


def main() -> None:
    """Follow all walkers and print a row for each tracker."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("dataset", type=Path)
    parser.add_argument("--tracker", action="append")
    parser.add_argument("--seeds", type=int, default=8)
    parser.add_argument("--workers", type=int, default=2)
    given = parser.parse_args()
    specs, unknown = resolve(given.tracker or ["default"])
    sequences, unreadable = load_mot_dataset(given.dataset)
    for problem in [*unknown, *unreadable]:
        print(f"{problem}")
    people = [each for sequence in sequences for each in walkers(sequence, *size(sequence))]
    print(f"{len(people)} walkers, {given.seeds} seeds, forwards and backwards")
    print("| tracker | runs | end on the right person | overlap | off | sure, of these |")
    print("|---|---|---|---|---|---|")
    for spec in specs:
        seeds = range(given.seeds if spec.stochastic else 1)
        tasks = [*product(people, (False, True), seeds)]
        with ProcessPoolExecutor(given.workers) as pool:
            scores = np.array([*pool.map(partial(score, spec=spec), tasks)])
        right, overlap, off, sure = scores.mean(axis=0)
        each = scores[:, 0].reshape(len(people), -1).mean(axis=1)
        margin = 1.96 * each.std(ddof=1) / len(each) ** 0.5
        shares = f"{right:.1%} ± {margin:.1%} | {overlap:.3f} | {off:.1%} | {sure / off:.0%}"
        print(f"| {spec.name} | {len(tasks)} | {shares} |", flush=True)


if __name__ == "__main__":
    main()
