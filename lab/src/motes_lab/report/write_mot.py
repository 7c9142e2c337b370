"""The report of an evaluation with many objects: summary.md, and report.html with plots."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from pathlib import Path

import numpy as np

from motes_lab.datasets.sot import Problem
from motes_lab.metrics import sot as metrics
from motes_lab.metrics.mot import ALPHAS
from motes_lab.mot_scores import MotEvaluation
from motes_lab.report import sections as report_sections
from motes_lab.report.markdown import document
from motes_lab.report.sections import Column
from motes_lab.report.tables import Cell, Table, number, three_digits
from motes_lab.report.write import Plot, curve_plot, page
from motes_lab.scores import PROTOCOL_NAMES, write_text

MOT = "mot"

MEASURES = {
    "HOTA": ("hota", 3, 1),
    "DetA": ("deta", 3, 1),
    "AssA": ("assa", 3, 1),
    "LocA": ("loca", 3, 1),
    "IDF1": ("idf1", 3, 1),
    "MOTA": ("mota", 3, 1),
    "MOTP": ("motp", 3, 1),
    "switches": ("switches", 0, -1),
    "fragmentations": ("fragmentations", 0, -1),
    "FP": ("false_positives", 0, -1),
    "FN": ("false_negatives", 0, -1),
    "mostly tracked": ("mostly_tracked", 0, 1),
    "mostly lost": ("mostly_lost", 0, -1),
}
"""Titles of columns; their names in results.csv, digits, and 1 if more is better, -1 if less is."""


def write_report(out: Path, evaluation: MotEvaluation, problems: list[Problem], title: str) -> None:
    """Write summary.md and report.html into a folder, as `report.write_report` does.

    Raises
    ------
    FormatError
        If a file cannot be written.
    """
    problems = report_sections.problems(problems, evaluation.outcomes)
    tables = [make(evaluation) for make in (overall, per_sequence, details, times)]
    sections = {PROTOCOL_NAMES[MOT]: tables} if evaluation.protocols else {}
    described = report_sections.run_summary(evaluation)
    write_text(out / "summary.md", document(title, described, sections, problems))
    text = page("many.html", evaluation, problems, title, tables=tables, plots=_plots(evaluation))
    write_text(out / "report.html", text)


def overall(evaluation: MotEvaluation) -> Table:
    """Return a table with a row for each tracker: its numbers over all sequences."""

    def mean(name: str, digits: int) -> Callable[[str], Cell]:
        return lambda tracker: _number(evaluation, tracker, name, digits)

    def time(tracker: str) -> Cell:
        return three_digits(metrics.time_quantiles(evaluation.seconds(tracker, MOT))[0])

    columns = [
        Column(title, mean(name, digits), sign) for title, (name, digits, sign) in MEASURES.items()
    ]
    return report_sections.ranking(
        "All sequences", evaluation, MOT, [*columns, Column("ms", time, -1)]
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


def per_sequence(evaluation: MotEvaluation) -> Table:
    """Return a table with a row for each sequence, and HOTA of each tracker."""
    return report_sections.per_sequence(evaluation, MOT)


def times(evaluation: MotEvaluation) -> Table:
    """Return a table of each tracker's running time of a frame."""
    return report_sections.times(evaluation, MOT)


def details(evaluation: MotEvaluation) -> Table:
    """Return a table with a row for each tracker on each sequence."""
    names = {"frames": ("frames", 0), "objects": ("objects", 0), "boxes": ("boxes", 0)}
    names |= {title: (name, digits) for title, (name, digits, _) in MEASURES.items()}

    def cells(tracker: str, sequence: str) -> Iterable[Cell]:
        return (_number(evaluation, tracker, *column, [sequence]) for column in names.values())

    return report_sections.by_tracker_and_sequence(evaluation, MOT, names, cells)


def _plots(evaluation: MotEvaluation) -> list[Plot]:
    """Return plots of HOTA and its two parts over the thresholds of overlap."""
    threshold = "threshold of overlap (IoU)"
    return [
        curve_plot(evaluation, MOT, quantity, ALPHAS, np.mean, (title, threshold, title, "mean"))
        for title, quantity in (
            ("HOTA", lambda t: t.hota), ("DetA", lambda t: t.deta), ("AssA", lambda t: t.assa)
        )
    ]  # fmt: skip
