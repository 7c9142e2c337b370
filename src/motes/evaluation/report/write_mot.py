"""The report of an evaluation with many objects: summary.md, and report.html with plots."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from pathlib import Path

import numpy as np

from motes.evaluation.datasets.sot import Problem
from motes.evaluation.metrics import sot as metrics
from motes.evaluation.metrics.mot import ALPHAS
from motes.evaluation.mot_scores import MotEvaluation
from motes.evaluation.report import html as page
from motes.evaluation.report import sections as report_sections
from motes.evaluation.report import write as report
from motes.evaluation.report.markdown import document
from motes.evaluation.report.sections import Column
from motes.evaluation.report.tables import Cell, Table, number, three_digits
from motes.evaluation.scores import PROTOCOL_NAMES, write_text

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

GLOSSARY = {
    "HOTA, DetA, AssA, LocA": "Higher order tracking accuracy: sqrt(DetA AssA), the mean over 19 "
    "thresholds of overlap (IoU) from 0.05 to 0.95 from which on a box is that of an object. DetA "
    "is the share TP / (TP + FN + FP) of boxes that are found; AssA the mean, over these, of the "
    "share of the boxes of its object and its track that are matches of these two; LocA their mean "
    "overlap. Luiten et al., HOTA, IJCV 2021.",
    "IDF1": "Share of boxes, true and found, that are matched (IoU from 0.5 on) if each object has "
    "one track and each track one object for the whole sequence. Ristani et al., ECCV workshops "
    "2016.",
    "MOTA, MOTP, FP, FN, switches": "MOTA is 1 - (FN + FP + switches) / boxes of the truth, with "
    "boxes matched frame by frame (IoU from 0.5 on): FP are those found that match none, FN those "
    "not found, a switch is another track than the one before. It may be negative. MOTP is the "
    "mean overlap of matches. Bernardin and Stiefelhagen, EURASIP JIVP 2008.",
    "Fragmentations; mostly tracked, mostly lost": "How often an object is found again after it "
    "was not; objects that are found in more than 80 %, and in less than 20 %, of their frames.",
    "All sequences": "Counted as one long sequence, in which no object is in two of them: not a "
    "mean over sequences.",
    "ms, updates a second": page.GLOSSARY["ms, updates a second"],
    "±": "Standard deviation over seeds. Without it, a tracker was run once, as chance plays no "
    "part in it, or with one seed.",
}
"""What the numbers of a report mean."""


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
    parts = _parts(evaluation) if evaluation.protocols else ()
    write_text(
        out / "report.html",
        page.page(title, report.body(evaluation, problems, parts, GLOSSARY)),
    )


def _parts(evaluation: MotEvaluation) -> Iterable[str]:
    yield page.headed(PROTOCOL_NAMES[MOT], page.table(overall(evaluation)))
    yield _plots(evaluation)
    tints = report.column_tints(len(evaluation.trackers))
    yield page.headed((table := per_sequence(evaluation)).title, page.table(table, tints))
    yield page.headed(
        (table := times(evaluation)).title,
        page.table(table, lambda row, _: report.tracker_tint(row)),
    )
    yield report.folded((table := details(evaluation)).title, table)


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
    """Return a table of the time that each tracker takes for a frame."""
    return report_sections.times(evaluation, MOT)


def details(evaluation: MotEvaluation) -> Table:
    """Return a table with a row for each tracker on each sequence."""
    names = {"frames": ("frames", 0), "objects": ("objects", 0), "boxes": ("boxes", 0)}
    names |= {title: (name, digits) for title, (name, digits, _) in MEASURES.items()}
    rows = [
        (
            Cell(tracker),
            Cell(sequence),
            *(_number(evaluation, tracker, *column, [sequence]) for column in names.values()),
        )
        for tracker in evaluation.trackers
        for sequence in evaluation.finished(tracker, MOT)
    ]
    return Table(
        "Each tracker on each sequence",
        ("tracker", "sequence", *names),
        rows,
        note="Mean ± standard deviation over seeds. More is in results.csv.",
    )


def _plots(evaluation: MotEvaluation) -> str:
    """Return plots of HOTA and its two parts over the thresholds of overlap."""
    threshold = "threshold of overlap (IoU)"
    drawn = (
        report.plot(
            evaluation, MOT, of, ALPHAS, np.mean, (title, threshold, title, "mean")
        )
        for title, of in (
            ("HOTA", lambda t: t.hota), ("DetA", lambda t: t.deta), ("AssA", lambda t: t.assa)
        )
    )  # fmt: skip
    return f'<div class="plots">{"".join(drawn)}</div>'
