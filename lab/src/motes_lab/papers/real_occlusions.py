"""Zhao and Pei's claim on film: two people keep their identities while one covers the other."""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np

from motes.cli import check_counts
from motes.core import Floats, iou
from motes.mot import assign
from motes_lab.adapters.registry import mot_tracker_spec, resolve
from motes_lab.datasets.distractors import MATCH_IOU, evaluated_rows
from motes_lab.datasets.mot import MotSequence
from motes_lab.datasets.mot_rows import MotRows
from motes_lab.datasets.sot import Problem
from motes_lab.experiment import Experiment, Result, ResultOptions
from motes_lab.finished_jobs import finished_jobs
from motes_lab.inputs import Seeds, crowds_of
from motes_lab.metrics.statistics import over
from motes_lab.mot_scores import MotOutcome
from motes_lab.report import sections as report_sections
from motes_lab.report.tables import Cell, Row, Table, number
from motes_lab.runner import Job, plan

TRACKERS = ("motes:scene", "trackers:sort", "trackers:bytetrack")

COVERED = 0.5
"""An occlusion covers at least this share of the farther box in some frame."""
APART = 5
"""Boxes have parted if they do not overlap in this many frames in a row."""
CONTEXT_FRAMES = 10
"""Identities are read from up to this many frames in which the boxes are apart, on each side."""
HEAD = (
    "sequence", "tracker", "runs", "occlusions", "kept", "changed", "not followed", "both kept"
)  # fmt: skip
NOTE = (
    f"Occlusions from the truth's boxes: the nearer one covers {COVERED:.0%} or more of the "
    f"farther one, and before and after that they are apart for {APART} frames or more. Kept, "
    f"changed and not followed: the identity of the farther person. Numbers are means over runs."
)


def real_occlusions(
    dataset: Path, /, *, seeds: Seeds = 5, results: ResultOptions = ResultOptions()
) -> int:
    """Zhao and Pei, section 3: occlusions on film.

    Parameters
    ----------
    dataset
        A folder of sequences of many objects, as for motes-lab evaluate.
    """
    check_counts(seeds=seeds)
    trackers, unusable = resolve(TRACKERS, mot_tracker_spec)
    crowds, problems = crowds_of(dataset)
    jobs, unreadable = plan(trackers, crowds, ["mot"], seeds)
    steps = kept_identities(crowds, [each.name for each in trackers], jobs)
    return results.show("real-occlusions", steps, [*unusable, *problems, *unreadable])


class Occlusion(NamedTuple):
    """A person whose box another one covers."""

    hidden: int
    front: int
    """Identities in the truth of the farther and of the nearer person."""
    before: range
    after: range
    """Frames in which the boxes are apart, next to the occlusion; they count from 1."""


class Counts(NamedTuple):
    """Numbers of occlusions, by what became of the farther person's identity, and both kept."""

    kept: int
    changed: int
    unknown: int
    both: int


def occlusions_of(truth: MotRows, frames: int) -> list[Occlusion]:
    """Return the occlusions of two people, from their boxes.

    The person with the higher lower edge is the farther one, as for a camera that looks down on
    level ground.
    """
    ids = np.unique(truth.ids)
    boxes = np.full((len(ids), frames, 4), np.nan)
    boxes[np.searchsorted(ids, truth.ids), truth.frames - 1] = truth.boxes
    found = []
    for i, j in itertools.combinations(range(len(ids)), 2):
        shares = _covered(boxes[i], boxes[j])
        covered = shares.max(axis=0)  # NaN where one of the two is not there
        touching = np.flatnonzero(covered > 0)
        for part in np.split(touching, np.flatnonzero(np.diff(touching) > APART) + 1):
            if not part.size or shares[:, part].max() < COVERED:
                continue
            first, last = int(part[0]), int(part[-1])
            before = _apart(covered[:first][::-1])
            after = _apart(covered[last + 1 :])
            if min(before, after) >= APART:
                near = int(shares[:, part].max(axis=1).argmin())
                hidden, front = (i, j) if near else (j, i)
                sides = range(first - before + 1, first + 1), range(last + 2, last + 2 + after)
                found.append(Occlusion(int(ids[hidden]), int(ids[front]), *sides))
    return found


def _covered(one: Floats, other: Floats) -> Floats:
    """Return how much of each of two people the other one covers, (2, frames), from boxes (n, 4).

    It is 0 for the nearer one, and NaN where one of the two is not there.
    """
    low = np.maximum(one[:, :2], other[:, :2])
    high = np.minimum(one[:, :2] + one[:, 2:], other[:, :2] + other[:, 2:])
    common = np.maximum(high - low, 0).prod(axis=1)
    farther = one[:, 1] + one[:, 3] < other[:, 1] + other[:, 3]
    parts = common / one[:, 2:].prod(axis=1), common / other[:, 2:].prod(axis=1)
    return np.array([parts[0] * farther, parts[1] * ~farther])


def _apart(covered: Floats) -> int:
    """Return in how many of the first frames nothing is covered, up to `CONTEXT_FRAMES`."""
    return int(np.append(covered[:CONTEXT_FRAMES] == 0, False).argmin())


def identities(truth: MotRows, results: MotRows) -> dict[tuple[int, int], int]:
    """Return the identity in the results, by frame and identity in the truth.

    In each frame, boxes are matched one to one with an overlap of `MATCH_IOU` or more.
    """
    names = {}
    for frame in np.intersect1d(truth.frames, results.frames).tolist():
        true_rows, rows = truth.at(frame), results.at(frame)
        overlaps = iou(truth.boxes[true_rows, None], results.boxes[rows])
        for i, j in assign(np.where(overlaps >= MATCH_IOU, 1 - overlaps, np.inf)):
            names[frame, int(truth.ids[true_rows][i])] = int(results.ids[rows][j])
    return names


def count(occlusions: Sequence[Occlusion], names: dict[tuple[int, int], int]) -> Counts:
    """Return how many occlusions leave identities as they were.

    Parameters
    ----------
    occlusions
        The occlusions.
    names
        The identities that a tracker gives, as from `identities`. That of a person before or after
        an occlusion is the most frequent one there; a person without one is not followed.
    """
    kept = changed = both = 0
    for each in occlusions:
        hidden, front = (
            [_most_frequent(names, person, side) for side in (each.before, each.after)]
            for person in (each.hidden, each.front)
        )
        followed, same = None not in hidden, hidden[0] == hidden[1]
        kept += followed and same
        changed += followed and not same
        both += followed and same and front[0] is not None and front[0] == front[1]
    return Counts(kept, changed, len(occlusions) - kept - changed, both)


def _most_frequent(names: dict[tuple[int, int], int], person: int, frames: range) -> int | None:
    found = [names[frame, person] for frame in frames if (frame, person) in names]
    return max(found, key=found.count) if found else None


def kept_identities(
    sequences: Sequence[MotSequence], trackers: Sequence[str], jobs: Sequence[Job]
) -> Experiment:
    """Yield after each job how many occlusions the identities of each tracker survive."""
    occlusions: dict[str, list[Occlusion]] = {}
    for each in sequences:
        truth, _ = evaluated_rows(each.truth, each.truth, ())
        occlusions[each.name] = occlusions_of(truth, each.frames)
    counts: dict[MotOutcome, Counts] = {}
    problems: list[Problem] = []
    for results, progress, share in finished_jobs(jobs):
        problems += report_sections.problems((), results)
        for outcome in results:
            if outcome.trace is not None:
                sequence = outcome.sequence
                rows = evaluated_rows(sequence.truth, outcome.trace.rows, sequence.distractors)
                counts[outcome] = count(occlusions[sequence.name], identities(*rows))
        table = _table(occlusions, trackers, counts)
        yield Result({"": table}, None, tuple(problems), progress, share)


def _table(
    occlusions: dict[str, list[Occlusion]],
    trackers: Sequence[str],
    counts: dict[MotOutcome, Counts],
) -> Table:
    """Return the counts by sequence and tracker, and those of the sequences together."""
    runs: dict[tuple[str, str], dict[int, Floats]] = {}
    for outcome, each in counts.items():
        item = outcome.item
        runs.setdefault((item.sequence, item.tracker), {})[item.seed] = np.array(each)
    rows = [
        _row(sequence, tracker, len(found), [*runs[sequence, tracker].values()])
        for sequence, found in occlusions.items()
        for tracker in trackers
        if (sequence, tracker) in runs
    ]
    foot = []
    for tracker in trackers:
        ended = {name: by_seed for (name, each), by_seed in runs.items() if each == tracker}
        seeds = set[int].intersection(*map(set, ended.values())) if ended else set()
        if seeds:
            sums = [np.sum([each[seed] for each in ended.values()], axis=0) for seed in seeds]
            foot.append(_row("all", tracker, sum(len(occlusions[name]) for name in ended), sums))
    return Table("Identities kept through occlusions on film", HEAD, rows, tuple(foot), NOTE)


def _row(sequence: str, tracker: str, many: int, counts: Sequence[Floats]) -> Row:
    """Return a row; counts are those of the runs, (4,) each."""
    means = (number(over(column), 1) for column in zip(*counts, strict=True))
    return (Cell(sequence), Cell(tracker), number(len(counts), 0), number(many, 0), *means)
