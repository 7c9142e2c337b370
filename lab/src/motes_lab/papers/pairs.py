"""Trackers compared with one other on the same films: claims of the papers, with margins."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Annotated, Literal

import numpy as np
from cyclopts import Parameter

from motes import Box, ConfigError
from motes.cli import check_counts
from motes.core import Floats
from motes_lab.adapters.registry import resolve
from motes_lab.aggregate import Evaluation
from motes_lab.datasets.shortened import shortened
from motes_lab.datasets.sot import Problem
from motes_lab.experiment import Experiment, Result, ResultOptions
from motes_lab.finished_jobs import finished_jobs
from motes_lab.inputs import RUN, FirstPixel, Only, Seeds, films_of
from motes_lab.metrics.statistics import over, paired_difference
from motes_lab.protocols.sot import Start
from motes_lab.report import sections as report_sections
from motes_lab.report.tables import NO_VALUE, Cell, Row, Table, difference, number
from motes_lab.runner import Job
from motes_lab.scores import Outcome

MARGIN = 0.03
"""Two trackers are alike if their difference is surely smaller."""
Measure = Literal["iou", "od"]
TITLES: dict[Measure, tuple[str, ...]] = {
    "iou": ("mean IoU",),
    "od": ("mean OD", "tracks lost"),  # lost if OD exceeds 0.8 in any frame
}


def pairs(
    dataset: Path,
    /,
    *tracker: str,
    sequence: Only = None,
    first_pixel: FirstPixel = None,
    measure: Annotated[Measure, Parameter(group=RUN, help="What is compared.")] = "iou",
    frames: Annotated[
        int, Parameter(group=RUN, help="Most frames of each film, from the target's first one.")
    ] = 150,
    every: Annotated[
        int, Parameter(group=RUN, help="Distance of these frames in the film; 3 is every third.")
    ] = 1,
    seeds: Seeds = 3,
    results: ResultOptions = ResultOptions(),
) -> int:
    """Claims of the papers on film: trackers beside one other.

    Parameters
    ----------
    dataset
        A folder of sequences or films as for motes-lab evaluate.
    tracker
        Trackers as for motes-lab evaluate; the first one is compared with the others.
    """
    check_counts(seeds=seeds, frames=frames, every=every)
    films, problems = films_of(dataset, first_pixel, sequence)
    trackers, unknown = resolve(tracker)
    if unknown or len(trackers) < 2:
        raise ConfigError(unknown[0].what if unknown else "Name two trackers or more to compare.")
    short = (shortened(film, frames, every) for film in films)
    jobs = [
        Job.of(trackers, film, [Start("ope", "", 0, Box(*film.boxes[0].tolist()))], seeds)
        for film in short
        if film
    ]
    apart = f", {every} apart" if every > 1 else ""
    note = f"At most {frames} frames of each film{apart}; seeds: {seeds}."
    steps = compared_pairs(jobs, dataset.resolve().name, measure, note)
    return results.show("pairs", steps, problems)


def compared_pairs(jobs: Sequence[Job], films: str, measure: Measure, note: str) -> Experiment:
    """Yield the scores of trackers over films, and their differences from the first tracker.

    A job has all trackers on a film; a film on which any of them fails is left out.
    """
    ended, problems = dict[str, list[Outcome]](), list[Problem]()
    names = [job.sequence.name for job in jobs]
    for results, progress, share in finished_jobs(jobs):
        if failed := report_sections.problems((), results):
            problems += failed
        else:
            ended[results[0].item.sequence] = results
        # In the order of the films, not of who was ready when: the bootstrap depends on it.
        outcomes = [each for name in names for each in ended.get(name, ())]
        tables = {"": compared(outcomes, films, measure, note)} if outcomes else {}
        yield Result(tables, None, tuple(problems), progress, share)


def compared(outcomes: Sequence[Outcome], films: str, measure: Measure, note: str) -> Table:
    """Return the scores of trackers, and their differences from the first one."""
    evaluation = Evaluation(outcomes)
    first, *_ = evaluation.trackers
    rows: list[Row] = []
    names = evaluation.sequences
    for tracker in evaluation.trackers:
        scores = [number(evaluation.mean(tracker, "ope", measure))]
        if measure == "od":
            lost = evaluation.per_seed(tracker, "ope", "lost_track", names) * len(names)
            scores.append(number(over(lost), 1))
        f1 = number(evaluation.lost_f1(tracker, "ope"))
        ends = [Cell(NO_VALUE)] * 3
        if tracker != first:
            ends = _difference(*(_each(evaluation, name, measure) for name in (tracker, first)))
        rows.append((Cell(films), number(len(names), 0), Cell(tracker), *scores, f1, *ends))
    head = (
        *("films", "number", "tracker", *TITLES[measure], "F1 of lost"),
        *("difference", "95 % interval", f"alike within {MARGIN}"),
    )
    about = (
        f"{note} Differences are from {first}, with a paired bootstrap over films; alike by two "
        f"one-sided tests at 5 %."
    )
    return Table(f"Compared with {first}", head, rows, note=about)


def _each(evaluation: Evaluation, tracker: str, measure: Measure) -> Floats:
    """Return a tracker's score on each film, the mean over its seeds."""
    names = evaluation.sequences
    return np.array([evaluation.mean(tracker, "ope", measure, [name]).mean for name in names])


def _difference(values: Floats, others: Floats) -> list[Cell]:
    _, least, most = paired_difference(values, others, level=0.9)
    alike = least > -MARGIN and most < MARGIN
    cells = difference(paired_difference(values, others))
    return [*cells, Cell("yes" if alike else "not shown")]
