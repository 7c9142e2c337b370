"""Trackers compared with one other on the same films: claims of the papers, with margins."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial
from typing import Literal, NamedTuple

import numpy as np

from motes.cluster import pool as pools
from motes.cluster.local import LocalPool
from motes.cluster.pool import Ended, Task
from motes.core.types import Floats
from motes_lab.adapters.registry import TrackerSpec
from motes_lab.aggregate import Evaluation
from motes_lab.datasets.sot import Problem
from motes_lab.datasets.sot import Sequence as Film
from motes_lab.metrics.sot import paired_difference
from motes_lab.papers.result import Experiment, Result, over
from motes_lab.protocols.perturbations import PerturbedSequence, perturbed_frames
from motes_lab.protocols.sot import Start, TrackerPass, starts
from motes_lab.report.sections import lost_track
from motes_lab.report.tables import NO_VALUE, Cell, Row, Table, number
from motes_lab.runner import Pass
from motes_lab.scores import Outcome

MARGIN = 0.03
"""Two trackers are alike if their difference is surely smaller."""
Measure = Literal["iou", "auc", "od"]
TITLES: dict[Measure, tuple[str, ...]] = {
    "iou": ("mean IoU",),
    "auc": ("AUC",),
    "od": ("mean OD", "tracks lost"),  # lost if OD exceeds 0.8 in any frame
}


class Shortened(NamedTuple):
    """A part of a film, and the passes over it; one task, as the film is decoded once.

    Attributes
    ----------
    film
        Its frames.
    trackers, seeds
        The trackers, and how often those that draw random numbers run.
    """

    film: PerturbedSequence
    trackers: Sequence[TrackerSpec]
    seeds: int


def shortened(film: Film, frames: int, every: int) -> PerturbedSequence | None:
    """Return a film from the first frame with the target on; None if there is none.

    Parameters
    ----------
    film
        The film.
    frames
        Most frames of the result.
    every
        Their distance in the film: with 3, every third one.
    """
    there = np.flatnonzero(np.isfinite(film.boxes).all(axis=1))
    if not there.size:
        return None
    chosen = np.arange(there[0], film.frames, every)[:frames]
    boxes, ellipses = film.boxes[chosen], film.ellipses[chosen]
    return PerturbedSequence(film.name, film.source, boxes, ellipses, film, "shortened", chosen)


def outcomes_of(task: Shortened) -> list[Outcome]:
    """Run all passes over a film, and return their results.

    All read the same frames: what one has computed of a frame, the next one need not.
    """
    film, passes = task.film, dict[Pass, TrackerPass]()
    for frame in perturbed_frames(film):
        frame.pixels.setflags(write=False)
        if not passes:
            [start] = starts("ope", film, frame.width, frame.height)
            passes = _passes(task, start)
        for each in passes.values():
            each.feed(frame)
    for each in passes.values():
        each.close()
    return [Outcome(film, item, each.trace) for item, each in passes.items()]


def _passes(task: Shortened, start: Start) -> dict[Pass, TrackerPass]:
    return {
        Pass(spec.name, task.film.name, start, seed): TrackerPass(
            partial(spec.begin, seed), start, task.film.boxes
        )
        for spec in task.trackers
        for seed in range(task.seeds if spec.stochastic else 1)
    }


def pairs(
    tasks: Sequence[Shortened], films: str, measure: Measure, note: str, workers: int
) -> Experiment:
    """Yield the scores of trackers over films, and their differences from the first tracker.

    Parameters
    ----------
    tasks
        The films, each with the same trackers.
    films
        The name of their set.
    measure, note
        What is compared, and what the table says of the films.
    workers
        Number of processes.
    """
    outcomes, problems = list[Outcome](), list[Problem]()
    with LocalPool(workers) as pool:
        events = pools.run(pool, (Task(t.film.name, outcomes_of, t) for t in tasks))
        for done, event in enumerate((each for each in events if isinstance(each, Ended)), 1):
            if event.error is not None:
                problems.append(Problem(f"film {event.task.name}", event.error))
            outcomes += event.value or []
            tables = {"": compared(outcomes, films, measure, note)} if outcomes else {}
            progress = f"{done} of {len(tasks)} films"
            yield Result(tables, None, tuple(problems), progress, done / len(tasks))


def compared(outcomes: Sequence[Outcome], films: str, measure: Measure, note: str) -> Table:
    """Return the scores of trackers, and their differences from the first one."""
    evaluation = Evaluation(outcomes)
    first, *_ = evaluation.trackers
    rows: list[Row] = []
    names = evaluation.sequences
    for tracker in evaluation.trackers:
        scores = [number(evaluation.mean(tracker, "ope", measure))]
        if measure == "od":
            lost = evaluation.per_seed(tracker, "ope", lost_track, names) * len(names)
            scores.append(number(over(lost), 1))
        f1 = number(evaluation.lost_status(tracker, "ope").f1)
        ends = [Cell(NO_VALUE)] * 3
        if tracker != first:
            ends = _difference(*(_each(evaluation, name, measure) for name in (tracker, first)))
        rows.append((Cell(films), number(len(names), 0), Cell(tracker), *scores, f1, *ends))
    head = (
        *("films", "number", "tracker", *TITLES[measure], "F1 of lost"),
        *("difference", "95 % interval", f"alike within {MARGIN}"),
    )
    about = (
        f"{note} Difference from {first}; intervals are a paired bootstrap over films. Alike: two "
        f"one-sided tests at 5 %, that is, a 90 % interval within the margin."
    )
    return Table(f"Compared with {first}", head, rows, note=about)


def _each(evaluation: Evaluation, tracker: str, measure: Measure) -> Floats:
    """Return a tracker's score on each film, the mean over its seeds."""
    names = evaluation.sequences
    return np.array([evaluation.mean(tracker, "ope", measure, [name]).mean for name in names])


def _difference(values: Floats, others: Floats) -> list[Cell]:
    mean, low, high = paired_difference(np.random.default_rng(0), values, others)
    _, least, most = paired_difference(np.random.default_rng(0), values, others, level=0.9)
    alike = least > -MARGIN and most < MARGIN
    interval = Cell(f"{low:+.3f} to {high:+.3f}") if np.isfinite(low) else Cell(NO_VALUE)
    return [Cell(f"{mean:+.3f}", mean), interval, Cell("yes" if alike else "not shown")]
