"""The tables of a report, and a summary of the run."""

from __future__ import annotations

import math
import platform
from collections import Counter
from collections.abc import Callable, Iterable
from typing import Any, NamedTuple

import numpy as np

from motes import __version__
from motes_lab.aggregate import Evaluation, Passes, ranking_column
from motes_lab.datasets.sot import Problem
from motes_lab.metrics import sot as metrics
from motes_lab.metrics.statistics import paired_difference
from motes_lab.report.reference import Reference
from motes_lab.report.tables import (
    NO_VALUE,
    Cell,
    Row,
    Table,
    bars,
    best,
    count_noun,
    difference,
    number,
    three_digits,
)
from motes_lab.runner import Pass
from motes_lab.scores import PROTOCOL_NAMES, PassResult

NAMES = {"auc": "AUC", "accuracy": "Accuracy", "hota": "HOTA"}
"""Titles of the columns by which trackers are ranked."""


class Column(NamedTuple):
    """A column: its title, a function of a tracker's name, and 1 if more is better, else -1."""

    title: str
    cell: Callable[[str], Cell]
    sign: int


def title(evaluation: Passes[Any], protocol: str) -> str:
    """Return a protocol's title, with the number of views for `robust`."""
    name = PROTOCOL_NAMES[protocol]
    views = len(_views(evaluation))
    return f"{name} ({count_noun(views, 'view')})" if protocol == "robust" else name


def _views(evaluation: Passes[Any]) -> list[str]:
    """Return the labels of the views that were run."""
    starts = (outcome.item.start for outcome in evaluation.outcomes)
    return list(dict.fromkeys(start.label for start in starts if start.protocol == "robust"))


def overall(evaluation: Evaluation, protocol: str) -> Table:
    """Return a table of means in a protocol, with a row for each tracker."""

    def mean(name: str, digits: int = 3) -> Callable[[str], Cell]:
        return lambda tracker: number(evaluation.mean(tracker, protocol, name), digits)

    def worst(tracker: str) -> Cell:
        return number(evaluation.worst_tenth(tracker, protocol))

    def f1(tracker: str) -> Cell:
        return number(evaluation.lost_status(tracker, protocol).f1)

    def calibration(tracker: str) -> Cell:
        return number(evaluation.calibration(tracker, protocol))

    def time(tracker: str) -> Cell:
        median, _ = metrics.time_quantiles(evaluation.seconds(tracker, protocol))
        return three_digits(median)

    columns = [
        Column("AUC", mean("auc"), 1),
        Column("precision at 20 px", mean("precision_20"), 1),
        Column("OD", mean("od"), -1),
        Column("tracks lost", mean("lost_track", 2), -1),
    ]
    if protocol == "robust":
        columns.insert(1, Column("AUC of the worst tenth", worst, 1))
    if protocol == "reset":
        columns = [
            Column("accuracy", mean("accuracy"), 1),
            Column("robustness", mean("robustness"), 1),
            Column("failures", mean("failures", 2), -1),
        ]
    columns += [
        Column("F1 of lost", f1, 1),
        Column("ECE", calibration, -1),
        Column("ms", time, -1),
    ]
    return ranking("All sequences", evaluation, protocol, columns)


def ranking(title: str, evaluation: Passes[Any], protocol: str, columns: list[Column]) -> Table:
    """Return a table with a row for each tracker, including the number of sequences it finished."""
    cells = [
        best([column.cell(tracker) for tracker in evaluation.trackers], column.sign)
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
        cells = bars(evaluation.mean(t, protocol, name, [sequence]) for t in trackers)
        failed = [sequence in attempted[t] - finished[t] for t in trackers]
        pairs = zip(cells, failed, strict=True)
        rows.append((Cell(sequence), *(Cell("failed") if bad else cell for cell, bad in pairs)))
    means = bars(evaluation.mean(tracker, protocol, name) for tracker in trackers)
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


def per_view(evaluation: Evaluation) -> Table:
    """Return a table with a row for each view of `robust` and a column for each tracker."""
    rows: list[Row] = [
        (
            Cell(label),
            *bars(evaluation.per_start(t, "robust", label) for t in evaluation.trackers),
        )
        for label in _views(evaluation)
    ]
    return Table("AUC in each view", ("view", *evaluation.trackers), rows)


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
    rows = [
        (Cell(tracker), *map(number, evaluation.lost_status(tracker, protocol)))
        for tracker in evaluation.trackers
    ]
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
    """Return a table of recoveries after losses, and of the accuracy of the covariance.

    In `reset`, the recoveries are left out, since the tracker is restarted there.
    """
    rows: list[Row] = []
    for tracker in evaluation.trackers:
        shares = [evaluation.coverage(tracker, protocol)]
        if protocol != "reset":
            shares.insert(0, evaluation.recovery(tracker, protocol))
        # A count has a fraction only if it is a mean.
        pairs = [(number(n, int(math.isfinite(n.deviation))), number(of)) for n, of in shares]
        rows.append((Cell(tracker), *(cell for pair in pairs for cell in pair)))
    head: tuple[str, ...] = ("tracker", "frames with a covariance", "truth within 95 %")
    note = (
        "Within 95 %: the share of these frames, with the target and status tracking, in which its "
        "true center lies in the 95 % ellipse of the tracker's position."
    )
    if protocol != "reset":
        head = ("tracker", "losses", "found again", *head[1:])
        note = (
            "A loss: the IoU falls below 0.1, and the target is later present for 30 frames in a "
            f"row. Found again: the share of losses with an IoU above 0.5 later. {note}"
        )
    return Table("Recovery after losses, and covariance", head, rows, note=note)


def times(evaluation: Passes[Any], protocol: str) -> Table:
    """Return a table of each tracker's running time of an update, with bars."""
    seconds = [evaluation.seconds(tracker, protocol) for tracker in evaluation.trackers]
    quantiles = [metrics.time_quantiles(each) for each in seconds]
    longest = max((high for _, high in quantiles if math.isfinite(high)), default=0)
    rows: list[Row] = []
    for tracker, (median, high), each in zip(evaluation.trackers, quantiles, seconds, strict=True):
        fps = each.size / each.sum() if each.sum() else math.nan
        cells = [
            cell._replace(bar=None if cell.value is None or not longest else cell.value / longest)
            for cell in (three_digits(median), three_digits(high))
        ]
        rows.append((Cell(tracker), *cells, three_digits(fps)))
    return Table(
        "Time of an update",
        ("tracker", "median, ms", "95 % within, ms", "updates per second"),
        rows,
        note="Time inside the tracker only, without decoding and without the start.",
    )


def reference(evaluation: Evaluation, other: Reference) -> Table:
    """Return a table of AUC in one pass, of this run and published, on the sequences of both."""
    title, protocol = f"With the results of {other.name}", "ope"
    if protocol not in evaluation.protocols:
        return Table(title, (), [], note="There is nothing to compare: one pass (OPE) was not run.")
    known = [
        sequence
        for sequence in evaluation.sequences
        if any(other.of(name, sequence) is not None for name in other.values)
    ]
    if not known:
        note = f"There is nothing to compare: {other.name} has none of the sequences of this run."
        return Table(title, (), [], note=note)
    columns = {
        tracker: {name: evaluation.mean(tracker, protocol, "auc", [name]).mean for name in known}
        for tracker in evaluation.trackers
        if evaluation.finished(tracker, protocol)
    }
    ours = len(columns)
    numbers = list(columns.values())
    head = list(columns)
    for name in other.values:
        column = {sequence: other.of(name, sequence) for sequence in known}
        if any(value is not None for value in column.values()):
            head.append(name)
            numbers.append({s: np.nan if v is None else v for s, v in column.items()})
    common = [s for s in known if all(math.isfinite(column[s]) for column in numbers)]
    means = [sum(column[s] for s in common) / len(common) if common else None for column in numbers]
    return Table(
        title,
        ("sequence", *head),
        [(Cell(s), *bars([column[s] for column in numbers])) for s in known],
        ((Cell(f"mean of {len(common)}"), *bars(means)),),
        f"AUC. The first {ours} columns are from this run, the others from {other.name}. The means "
        f"are over the {len(common)} sequences for which all columns have a number.",
    )


def details(evaluation: Evaluation, protocol: str) -> Table:
    """Return a table with a row for each tracker on each sequence."""
    columns: dict[str, tuple[str, int]] = {"frames": ("frames", 0)}
    if protocol == "reset":
        columns |= {"accuracy": ("accuracy", 3), "robustness": ("robustness", 3)}
        columns |= {"failures": ("failures", 1)}
    else:
        columns |= {"AUC": ("auc", 3), "precision at 20 px": ("precision_20", 3)}
        columns |= {"IoU": ("iou", 3), "OD": ("od", 3), "track lost": ("lost_track", 2)}
    columns |= {"F1 of lost": ("lost_f1", 2), "ECE": ("ece", 3), "ms": ("ms_median", 2)}

    def cells(tracker: str, sequence: str) -> Iterable[Cell]:
        for name, digits in columns.values():
            yield number(evaluation.mean(tracker, protocol, name, [sequence]), digits)

    return by_tracker_and_sequence(evaluation, protocol, columns, cells)


def by_tracker_and_sequence(
    evaluation: Passes[Any],
    protocol: str,
    columns: Iterable[str],
    cells: Callable[[str, str], Iterable[Cell]],
) -> Table:
    """Return a table with a row for each tracker on each sequence that it finished.

    `cells` gives the cells of the columns from the names of tracker and sequence.
    """
    rows = [
        (Cell(tracker), Cell(sequence), *cells(tracker, sequence))
        for tracker in evaluation.trackers
        for sequence in evaluation.finished(tracker, protocol)
    ]
    return Table(
        "Each tracker on each sequence",
        ("tracker", "sequence", *columns),
        rows,
        note="Mean ± standard deviation over seeds. More is in results.csv.",
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
