"""The tables of a report, and a summary of the run."""

from __future__ import annotations

import math
import platform
from collections import Counter
from collections.abc import Callable, Iterable
from typing import Any, NamedTuple

import numpy as np

from motes import __version__
from motes_lab.aggregate import Evaluation, Passes, ranking_column, sign_of
from motes_lab.datasets.sot import Problem
from motes_lab.metrics import sot as metrics
from motes_lab.metrics.statistics import over, paired_difference
from motes_lab.report.tables import (
    NO_VALUE,
    Cell,
    Row,
    Table,
    best,
    count_noun,
    difference,
    number,
    three_digits,
)
from motes_lab.runner import Pass
from motes_lab.scores import PassResult

NAMES = {"auc": "AUC", "hota": "HOTA"}
"""Titles of the columns by which trackers are ranked."""


class Column(NamedTuple):
    """A column: its title, the name of its number in results.csv, and its cell for a tracker."""

    title: str
    name: str
    cell: Callable[[str], Cell]


def tables(evaluation: Evaluation, protocol: str) -> list[Table]:
    """Return the tables of a protocol, the means first."""
    compared = [comparisons(evaluation, protocol)] if len(evaluation.trackers) > 1 else []
    others = [make(evaluation, protocol) for make in (per_sequence, lost_status, recovery, times)]
    return [overall(evaluation, protocol), *compared, *others]


def overall(evaluation: Evaluation, protocol: str) -> Table:
    """Return a table of means in a protocol, with a row for each tracker."""

    def mean(name: str, digits: int = 3) -> Callable[[str], Cell]:
        return lambda tracker: number(evaluation.mean(tracker, protocol, name), digits)

    def f1(tracker: str) -> Cell:
        return number(evaluation.lost_f1(tracker, protocol))

    def calibration(tracker: str) -> Cell:
        return number(evaluation.calibration(tracker, protocol))

    def time(tracker: str) -> Cell:
        median, _ = metrics.time_quantiles(evaluation.seconds(tracker, protocol))
        return three_digits(median)

    columns = [
        Column("AUC", "auc", mean("auc")),
        Column("precision at 20 px", "precision_20", mean("precision_20")),
        Column("OD", "od", mean("od")),
        Column("tracks lost", "lost_track", mean("lost_track", 2)),
        Column("F1 of lost", "lost_f1", f1),
        Column("ECE", "ece", calibration),
        Column("ms", "ms_median", time),
    ]
    return ranking("All sequences", evaluation, protocol, columns)


def ranking(title: str, evaluation: Passes[Any], protocol: str, columns: list[Column]) -> Table:
    """Return a table with a row for each tracker, including the number of sequences it finished."""
    cells = [
        best([column.cell(tracker) for tracker in evaluation.trackers], sign_of(column.name))
        for column in columns
    ]
    rows: list[Row] = []
    for i, tracker in enumerate(evaluation.trackers):
        finished = len(evaluation.finished(tracker, protocol))
        share = f"{finished} of {len(evaluation.attempted(tracker, protocol))}"
        rows.append((Cell(tracker), Cell(share, finished), *(column[i] for column in cells)))
    head = ("tracker", "sequences", *(column.title for column in columns))
    return Table(title, head, rows)


def per_sequence(evaluation: Passes[Any], protocol: str) -> Table:
    """Return a table with a row for each sequence and a column for each tracker."""
    name, trackers = ranking_column(protocol), evaluation.trackers
    attempted = {tracker: set(evaluation.attempted(tracker, protocol)) for tracker in trackers}
    finished = {tracker: set(evaluation.finished(tracker, protocol)) for tracker in trackers}
    rows: list[Row] = []
    for sequence in evaluation.sequences:
        cells = best(number(evaluation.mean(t, protocol, name, [sequence])) for t in trackers)
        failed = [sequence in attempted[t] - finished[t] for t in trackers]
        pairs = zip(cells, failed, strict=True)
        rows.append((Cell(sequence), *(Cell("failed") if bad else cell for cell, bad in pairs)))
    means = best(number(evaluation.mean(tracker, protocol, name)) for tracker in trackers)
    foot, note = "mean", "The mean of a tracker is over the sequences that it finished."
    if protocol == "mot":
        foot, note = "all", "The last line counts all sequences that a tracker finished as one."
    return Table(
        f"{NAMES[name]} on each sequence",
        ("sequence", *trackers),
        rows,
        ((Cell(foot), *means),),
        note,
    )


def comparisons(evaluation: Evaluation, protocol: str) -> Table:
    """Return a table in which each tracker is compared with the first one.

    The value of a sequence is its mean over seeds of the `ranking_column`.
    """
    first, *others = evaluation.trackers
    column = ranking_column(protocol)
    rows: list[Row] = []
    for tracker in others:
        pairs = [
            [evaluation.mean(each, protocol, column, [name]).mean for each in (tracker, first)]
            for name in evaluation.finished(tracker, protocol)
        ]
        known = [pair for pair in pairs if np.isfinite(pair).all()]
        ours, theirs = np.array(known, np.float64).reshape(-1, 2).T
        won, drawn = (int(np.count_nonzero(each)) for each in (ours > theirs, ours == theirs))
        counts = [Cell(f"{won} of {ours.size}", won), Cell(str(drawn), drawn)]
        rows.append(
            (
                Cell(tracker),
                *difference(paired_difference(ours, theirs)),
                *(counts if known else [Cell(NO_VALUE)] * 2),
            )
        )
    head = ("tracker", f"difference of {NAMES[column]}", "95 % interval", "sequences won", "drawn")
    note = (
        f"A positive difference means better than {first}, over the sequences that both finished. "
        f"The interval is a paired bootstrap over sequences, each with its mean over seeds. If it "
        f"contains 0, these sequences do not show which one is better."
    )
    return Table(f"Compared with {first}", head, rows, note=note)


def lost_status(evaluation: Evaluation, protocol: str) -> Table:
    """Return a table of how well each tracker reports its losses."""
    shares = ("missed", "judged"), ("reported", "judged"), ("both", "missed"), ("both", "reported")
    rows: list[Row] = []
    for tracker in evaluation.trackers:
        cells = (number(evaluation.share(tracker, protocol, *of)) for of in shares)
        rows.append((Cell(tracker), *cells, number(evaluation.lost_f1(tracker, protocol))))
    return Table(
        "Reported losses",
        ("tracker", "frames missed", "frames reported lost", "recall", "precision", "F1"),
        rows,
        note=(
            "A frame is missed if the IoU is below 0.1 or there is no target. Recall: the share of "
            "missed frames that were reported lost. Precision: the share of frames reported lost "
            "that were missed. Over the frames of all sequences."
        ),
    )


def recovery(evaluation: Evaluation, protocol: str) -> Table:
    """Return a table of recoveries after losses, and of the accuracy of the covariance."""
    rows: list[Row] = []
    for tracker in evaluation.trackers:
        cells: list[Cell] = []
        for part, whole in (("recovered", "losses"), ("covered", "known")):
            total = over(evaluation.sums(tracker, protocol)[whole])
            # A count has a fraction only if it is a mean.
            cells.append(number(total, int(math.isfinite(total.deviation))))
            cells.append(number(evaluation.share(tracker, protocol, part, whole)))
        rows.append((Cell(tracker), *cells))
    return Table(
        "Recovery after losses, and covariance",
        ("tracker", "losses", "found again", "frames with a covariance", "truth within 95 %"),
        rows,
        note=(
            "A loss: the IoU falls below 0.1, and the target is later present for 30 frames in a "
            "row. Found again: the share of losses with an IoU above 0.5 later. Within 95 %: the "
            "share of these frames, with the target and status tracking, in which its true center "
            "lies in the 95 % ellipse of the tracker's position."
        ),
    )


def times(evaluation: Passes[Any], protocol: str) -> Table:
    """Return a table of each tracker's running time of an update."""
    rows: list[Row] = []
    for tracker in evaluation.trackers:
        seconds = evaluation.seconds(tracker, protocol)
        rate = seconds.size / seconds.sum() if seconds.sum() else math.nan
        numbers = map(three_digits, (*metrics.time_quantiles(seconds), rate))
        rows.append((Cell(tracker), *numbers))
    return Table(
        "Time of an update",
        ("tracker", "median, ms", "95 % within, ms", "updates per second"),
        rows,
        note="Time inside the tracker only, without decoding and without the start.",
    )


def problems(found: Iterable[Problem], outcomes: Iterable[PassResult[Any, Any]]) -> list[Problem]:
    """Return the problems, and the failed passes, with one entry for each sequence and error."""
    failed: dict[tuple[str, str], list[Pass]] = {}
    for outcome in outcomes:
        if outcome.trace is None:
            failed.setdefault((outcome.item.sequence, outcome.error), []).append(outcome.item)
    return [*found, *(Problem(pass_label(items), error) for (_, error), items in failed.items())]


def pass_label(items: list[Pass]) -> str:
    """Return the name of passes over a sequence, such as "cv2:csrt on David, ope, seed 0"."""
    item, *others = items
    if others:
        trackers = ", ".join(dict.fromkeys(item.tracker for item in items))
        return f"{trackers} on {item.sequence}, {count_noun(len(items), 'pass')}"
    label = f" {item.start.label}" if item.start.label else ""
    return f"{item.tracker} on {item.sequence}, {item.start.protocol}{label}, seed {item.seed}"


def problem_table(found: list[Problem]) -> Table:
    """Return a table of problems."""
    rows: list[Row] = [(Cell(problem.where), Cell(problem.what)) for problem in found]
    return Table("Problems", ("where", "what"), rows)


def run_summary(evaluation: Passes[Any]) -> str:
    """Return a sentence about what was run."""
    if not evaluation.outcomes:
        return "Nothing was run."
    failed = sum(outcome.trace is None for outcome in evaluation.outcomes)
    passes = Counter(outcome.item.start.protocol for outcome in evaluation.outcomes)
    each = ", ".join(f"{passes[protocol]} {protocol}" for protocol in evaluation.protocols)
    return (
        f"{count_noun(len(evaluation.trackers), 'tracker')} on "
        f"{count_noun(len(evaluation.sequences), 'sequence')}, "
        f"{count_noun(len({outcome.item.seed for outcome in evaluation.outcomes}), 'seed')} "
        f"for stochastic trackers. Passes: {each}; "
        f"{failed or 'none'} of them failed. "
        f"motes {__version__}, Python {platform.python_version()}, {platform.machine()}."
    )
