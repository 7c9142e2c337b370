"""The tables of a report on many objects."""

from __future__ import annotations

from collections.abc import Callable, Mapping

import numpy as np

from motes_lab.metrics import sot as metrics
from motes_lab.mot_scores import MotEvaluation
from motes_lab.report import sections
from motes_lab.report.sections import Column
from motes_lab.report.tables import Cell, Table, number, three_digits

MOT = "mot"

SIZES = {"frames": ("frames", 0), "objects": ("objects", 0), "boxes": ("boxes", 0)}
MEASURES = {
    "HOTA": ("hota", 3),
    "DetA": ("deta", 3),
    "AssA": ("assa", 3),
    "LocA": ("loca", 3),
    "IDF1": ("idf1", 3),
    "MOTA": ("mota", 3),
    "MOTP": ("motp", 3),
    "switches": ("switches", 0),
    "fragmentations": ("fragmentations", 0),
    "FP": ("false_positives", 0),
    "FN": ("false_negatives", 0),
    "mostly tracked": ("mostly_tracked", 0),
    "mostly lost": ("mostly_lost", 0),
}
"""Titles of columns; their names in results.csv, and digits."""
ERRORS = {
    "handed over": ("handovers", 0),
    "exchanged": ("exchanges", 0),
    "ghosts": ("ghosts", 0),
    "doubled": ("doubled", 0),
    "merged": ("merged", 0),
    "late": ("late", 0),
}
"""The same of what a user sees go wrong, for each sequence."""


def tables(evaluation: MotEvaluation) -> list[Table]:
    """Return all tables, the one over all sequences first."""
    return [
        overall(evaluation),
        sections.per_sequence(evaluation, MOT),
        each(evaluation, "Each tracker on each sequence", SIZES | MEASURES),
        each(evaluation, "What goes wrong on each sequence", ERRORS),
        sections.times(evaluation, MOT),
    ]


def overall(evaluation: MotEvaluation) -> Table:
    """Return a table with a row for each tracker: its numbers over all sequences."""

    def mean(name: str, digits: int) -> Callable[[str], Cell]:
        return lambda tracker: _number(evaluation, tracker, name, digits)

    def time(tracker: str) -> Cell:
        return three_digits(metrics.time_quantiles(evaluation.seconds(tracker, MOT))[0])

    columns = [
        Column(title, name, mean(name, digits)) for title, (name, digits) in MEASURES.items()
    ]
    return sections.ranking(
        "All sequences", evaluation, MOT, [*columns, Column("ms", "ms_median", time)]
    )


def _number(
    evaluation: MotEvaluation,
    tracker: str,
    name: str,
    digits: int,
    sequences: list[str] | None = None,
) -> Cell:
    mean = evaluation.mean(tracker, MOT, name, sequences)
    # A count has a fraction only if it is a mean.
    return number(mean, digits or int(np.isfinite(mean.deviation)))


def each(evaluation: MotEvaluation, title: str, columns: Mapping[str, tuple[str, int]]) -> Table:
    """Return a table with a row for each tracker on each sequence that it finished."""
    rows = [
        (
            Cell(tracker),
            Cell(sequence),
            *(_number(evaluation, tracker, *column, [sequence]) for column in columns.values()),
        )
        for tracker in evaluation.trackers
        for sequence in evaluation.finished(tracker, MOT)
    ]
    return Table(
        title,
        ("tracker", "sequence", *columns),
        rows,
        note="Mean ± standard deviation over seeds. More is in results.csv.",
    )
