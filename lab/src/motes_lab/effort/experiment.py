"""The effort of annotation on all sequences of a dataset: keyframes until 95 % is right."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np

from motes import preset
from motes.core import Floats
from motes.video import Film as Reader
from motes_fleet.cluster import pool as pools
from motes_fleet.cluster.machine import cores
from motes_fleet.cluster.open_pool import open_pool
from motes_lab.datasets.sot import Problem, Sequence as Film
from motes_lab.effort.annotator import Effort, annotate, annotate_equidistant
from motes_lab.effort.methods import METHODS, Film as Work
from motes_lab.experiment import Experiment, Result, ResultOptions
from motes_lab.inputs import FirstPixel, films_of
from motes_lab.metrics.statistics import over
from motes_lab.report.tables import Cell, Row, Table, number

INTERPOLATION, EQUIDISTANT = "interpolation", "interpolation, equidistant"
NAMES = (*METHODS, EQUIDISTANT)

Efforts = Mapping[str, Mapping[str, Effort]]
"""By sequence, then by method."""


def effort(
    dataset: Path, /, *, first_pixel: FirstPixel = None, results: ResultOptions = ResultOptions()
) -> int:
    """Effort of annotation: keyframes until 95 % is right.

    A simulated annotator marks the first frame, and then one frame after the other with its true
    box, until 95 % of the frames have an IoU of 0.7 or more. The next one is that of the largest
    expected gain, as in motes check. Between the keyframes are tracks in both directions, a track
    that is started anew at each keyframe, or linear interpolation.

    Parameters
    ----------
    dataset
        A folder of sequences as for motes-lab evaluate.
    """
    films, problems = films_of(dataset, first_pixel)
    return results.show("effort", efforts_on(films), problems)


def efforts_on(films: Sequence[Film]) -> Experiment:
    """Yield tables of the results so far; they grow with each sequence."""
    efforts: dict[str, dict[str, Effort]] = {}
    problems: list[Problem] = []
    tasks = [pools.Task(film.name, of_film, film, seconds=math.inf) for film in films]
    with open_pool(None, cores()) as pool:
        ended = (event for event in pools.run(pool, tasks) if isinstance(event, pools.Ended))
        for done, event in enumerate(ended, 1):
            if event.error is None:
                efforts[event.task.name] = event.value
            else:
                problems.append(Problem(f"sequence {event.task.name}", event.error))
            ordered = {film.name: efforts[film.name] for film in films if film.name in efforts}
            tables = {"means": means(ordered), "sequences": sequences(ordered)} if efforts else {}
            progress, share = f"{len(efforts)} sequences", done / len(tasks)
            yield Result(tables, None, tuple(problems), progress, share)


def of_film(film: Film) -> dict[str, Effort]:
    """Return the effort of each method on a sequence."""
    present = np.flatnonzero(np.isfinite(film.boxes).all(axis=1))
    reader = Reader(film.source, start=int(present[0]), end=film.frames)
    work = Work(reader, reader.frames, preset("default"))
    found = {name: annotate(work, film.boxes, method) for name, method in METHODS.items()}
    return found | {EQUIDISTANT: annotate_equidistant(work, film.boxes)}


def rates(efforts: Efforts, name: str) -> Floats:
    """Return the corrections for each 100 frames of a method, (sequences,)."""
    return np.array([of_each[name].rate for of_each in efforts.values()])


def means(efforts: Efforts) -> Table:
    """Return a table with a row for each method."""
    reference = rates(efforts, INTERPOLATION)
    rows: list[Row] = []
    for name in NAMES:
        values = rates(efforts, name)
        fewer = int((values < reference).sum())
        ratio = float(values.mean() / reference.mean()) if reference.mean() else float("nan")
        rows.append(
            (
                Cell(name),
                number(over(values), 1),
                number(float(np.median(values)), 1),
                number(ratio, 2),
                Cell(f"{fewer} of {len(values)}", fewer),
            )
        )
    note = (
        f"Corrections for each 100 frames until 95 % of the frames have an IoU of 0.7 or more: "
        f"mean ± standard deviation over {len(reference)} sequences. The next keyframe is the "
        f"frame that motes check names."
    )
    head = ("method", "corrections", "median", "ratio to interpolation", "fewer than it")
    return Table("Effort of an annotator", head, rows, note=note)


def sequences(efforts: Efforts) -> Table:
    """Return a table with a row for each sequence."""
    rows = [
        (
            Cell(sequence),
            Cell(str(of_each[NAMES[0]].frames), of_each[NAMES[0]].frames),
            *(number(of_each[name].rate, 1) for name in NAMES),
        )
        for sequence, of_each in efforts.items()
    ]
    note = "Corrections for each 100 frames."
    return Table("Effort on each sequence", ("sequence", "frames", *NAMES), rows, note=note)
