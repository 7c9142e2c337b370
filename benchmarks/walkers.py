"""Walkers in crowds, each followed alone or all together: how many runs end on the right person.

    python benchmarks/walkers.py MOT_FOLDER [--tracker default ...] [--together] [--seeds 8]

A walker is an identity of the truth that is wholly in the picture for `LEAST` frames in a row; the
first `MOST` of its longest such stretch are followed, forwards and backwards. Crowds are chaotic:
one exchange for a neighbor decides the rest of a run, so single mean overlaps say little. The
interval of a mean is that over walkers (95 %), each the mean of its runs. `--together` follows the
walkers of a sequence by one `Trackers` as well, each over its own frames.
"""

from __future__ import annotations

import argparse
from collections.abc import Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor
from functools import partial
from itertools import product
from pathlib import Path
from typing import NamedTuple

import numpy as np

from motes import Trackers
from motes.core.frame import Frame
from motes.core.geometry import Box, Ellipse, iou
from motes.core.track import Status
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


Said = tuple[Ellipse | None, bool]
"""What a tracker says after a frame: where the target is, and whether it is sure of it."""


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


def pictures(walker: Walker, *, backward: bool) -> tuple[list[Frame], Floats]:
    """Return the frames of a walker, numbered from 0 to the last of all frames, and his boxes."""
    with open_source(walker.sequence.source) as source:
        every = [frame.pixels for frame in source]
    first, boxes = walker.first, walker.boxes
    if backward:
        every, boxes, first = every[::-1], boxes[::-1], len(every) - walker.first - len(boxes)
    rate = walker.sequence.rate
    own = range(first, first + len(boxes))
    return [Frame(index, index / rate, every[index]) for index in own], boxes


def alone(task: tuple[Walker, bool, int], spec: TrackerSpec) -> Score:
    """Return the score of a run: a walker, whether backward, and a seed."""
    walker, backward, seed = task
    frames, boxes = pictures(walker, backward=backward)
    tracker = spec.begin(seed)
    tracker.init(frames[0], Box(*boxes[0]))
    said = []
    for picture in frames[1:]:
        answer = tracker.update(picture)
        sure = not answer.lost and not answer.confidence <= SURE  # NaN: it says nothing
        said.append((answer.ellipse, sure))
    return score(said, boxes)


def together(task: tuple[list[Walker], bool, int], spec: TrackerSpec) -> list[Score]:
    """Return the scores of the walkers of a sequence who are followed at once."""
    people, backward, seed = task
    films = [pictures(each, backward=backward) for each in people]
    begins = [frames[0].index for frames, _ in films]
    every = {picture.index: picture for frames, _ in films for picture in frames}
    trackers, followed = Trackers(spec.name, seed), dict[int, int]()  # identities of walkers
    said: list[list[Said]] = [[] for _ in people]
    for index in sorted(every):
        for n in [n for n in followed if films[n][0][-1].index < index]:
            trackers.remove(followed.pop(n))
        tracks = trackers.update(every[index]) if index > min(begins) else []
        for n, track in zip(followed, tracks, strict=True):
            sure = track.status is Status.TRACKING and track.confidence > SURE
            said[n].append((track.ellipse, sure))
        for n, (_, boxes) in enumerate(films):
            if begins[n] == index:
                region = Box(*boxes[0])
                if index == min(begins) and not followed:
                    (track,) = trackers.init(every[index], [region])
                else:
                    track = trackers.add(region)
                followed[n] = track.identity
    return [score(each, boxes) for each, (_, boxes) in zip(said, films, strict=True)]


def score(said: Sequence[Said], boxes: Floats) -> Score:
    """Return the score of a run: after each frame the place, and whether the tracker is sure."""
    overlap = np.array([
        0.0 if found is None else float(iou(found.box, Box(*box)))
        for (found, _), box in zip(said, boxes[1:], strict=True)
    ])  # fmt: skip
    off, sure = overlap < OFF, np.array([sure for _, sure in said])
    right = np.mean(overlap[-LAST:] > RIGHT) > 0.5
    return Score(float(right), overlap.mean(), off.mean(), float((off & sure).mean()))


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
    parser.add_argument("--together", action="store_true")
    parser.add_argument("--seeds", type=int, default=8)
    parser.add_argument("--workers", type=int, default=2)
    given = parser.parse_args()
    specs, unknown = resolve(given.tracker or ["default"])
    sequences, unreadable = load_mot_dataset(given.dataset)
    for problem in [*unknown, *unreadable]:
        print(f"{problem}")
    crowds = [[*walkers(sequence, *size(sequence))] for sequence in sequences]
    people = [each for crowd in crowds for each in crowd]
    print(f"{len(people)} walkers, {given.seeds} seeds, forwards and backwards")
    print("| tracker | runs | end on the right person | overlap | off | sure, of these |")
    print("|---|---|---|---|---|---|")
    for spec in specs:
        seeds = range(given.seeds if spec.stochastic else 1)
        with ProcessPoolExecutor(given.workers) as pool:
            scores = pool.map(partial(alone, spec=spec), product(people, (False, True), seeds))
            show(spec.name, np.array([*scores]).reshape(len(people), 2 * len(seeds), -1))
            if given.together:
                runs = [
                    np.array([*pool.map(partial(together, spec=spec), tasks)]).swapaxes(0, 1)
                    for tasks in (product([crowd], (False, True), seeds) for crowd in crowds)
                ]
                show(f"{spec.name}, together", np.concatenate(runs))


def show(name: str, scores: Floats) -> None:
    """Print a row of the scores (walkers, runs, 4)."""
    right, overlap, off, sure = scores.mean(axis=(0, 1))
    each = scores[:, :, 0].mean(axis=1)
    margin = 1.96 * each.std(ddof=1) / len(each) ** 0.5
    shares = f"{right:.1%} ± {margin:.1%} | {overlap:.3f} | {off:.1%} | {sure / off:.0%}"
    print(f"| {name} | {scores[:, :, 0].size} | {shares} |", flush=True)


if __name__ == "__main__":
    main()
