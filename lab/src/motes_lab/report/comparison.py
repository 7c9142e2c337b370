"""Tables that compare evaluations: of trackers, of versions, and of two sets of sequences."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence

import numpy as np
import pandas as pd

from motes import ConfigError
from motes.core import Floats
from motes_lab.adapters.networks import short_name
from motes_lab.aggregate import sign_of
from motes_lab.experiment import Experiment, Result
from motes_lab.metrics.statistics import paired_difference, unpaired_difference
from motes_lab.report.sections import NAMES
from motes_lab.report.tables import Cell, Row, Table, difference, number
from motes_lab.saved_scores import SavedScores

INTERVAL = "The interval is a bootstrap over sequences, each with its mean over starts and seeds."
PEER = "cv2:csrt"
"""The tracker that others are compared with where every run has it."""


def default_reference(runs: Sequence[SavedScores]) -> str:
    """Return the tracker that others are compared with unless one is named.

    It is `PEER`; without it, the first one that all runs have, as in the report of an evaluation.
    """
    first, *others = ([short_name(each) for each in run.values] for run in runs)
    shared = [each for each in first if all(each in other for other in others)]
    return PEER if PEER in shared else [*shared, *first][0]


def comparison(runs: list[SavedScores], reference: str) -> Experiment:
    """Yield the tables that one or more runs allow; further runs are compared with the first.

    Parameters
    ----------
    runs
        Evaluations in one protocol.
    reference
        The tracker that others are compared with.

    Raises
    ------
    ConfigError
        If a run has another protocol than the first, or not the reference, or no number of it; or
        if there is nothing to compare.
    """
    first, *others = runs
    for run in runs:
        if run.protocol != first.protocol:
            raise ConfigError(
                f"{run.name} has the protocol {run.protocol}, and {first.name} {first.protocol}; "
                f"choose one with --protocol."
            )
        if run.values[tracker_named(run, reference)].isna().all():
            raise ConfigError(
                f"{run.name} has no number {run.column} of {reference}; choose another --reference "
                f"or --column."
            )
    compared = trackers(runs, reference)
    if not (compared.rows or others):
        raise ConfigError(f"{first.name} has {reference} alone; give a run to compare it with.")
    tables = {"trackers": compared} if compared.rows else {}
    if any(_common(first, other) for other in others):
        tables["versions"] = versions(first, others)
    if any(not _common(first, other) for other in others):
        tables["optimism"] = optimism(first, others, reference)
    yield Result(tables)


def tracker_named(run: SavedScores, name: str) -> str:
    """Return the tracker of a run by its short name; raise a ConfigError if there is none."""
    for tracker in run.values:
        if name in (tracker, short_name(tracker)):
            return str(tracker)
    raise ConfigError(
        f"{run.name} has no tracker {name}; it has {', '.join(map(short_name, run.values))}."
    )


def pairs(
    run: SavedScores, tracker: str, other: SavedScores, against: str
) -> tuple[Floats, Floats]:
    """Return the values of two trackers on the sequences that both finished, (n,) each."""
    both = pd.concat([run.values[tracker], other.values[against]], axis=1, join="inner").dropna()
    ours, theirs = both.to_numpy(float).T
    return ours, theirs


def _common(run: SavedScores, other: SavedScores) -> bool:
    """Return whether two runs have a sequence in common."""
    return bool(run.values.index.intersection(other.values.index).size)


def trackers(runs: list[SavedScores], reference: str) -> Table:
    """Return a table of each tracker's difference from the reference, in each run."""
    rows: list[Row] = []
    for run in runs:
        against = tracker_named(run, reference)
        for tracker in run.values:
            if tracker != against:
                rows.append(_row(run, tracker, *pairs(run, tracker, run, against)))
    note = f"Means over the sequences that both finished. {INTERVAL}"
    return Table(f"Compared with {reference}", _head(runs[0].column, reference), rows, note=note)


def versions(first: SavedScores, others: Iterable[SavedScores]) -> Table:
    """Return a table of each tracker's difference from itself in the first run."""
    rows: list[Row] = []
    for run in others:
        for tracker in run.values.columns.intersection(first.values.columns, sort=False):
            found = pairs(run, tracker, first, tracker)
            if found[0].size:
                rows.append(_row(run, tracker, *found))
    note = f"Means over the sequences of both runs. {INTERVAL}"
    return Table(f"Compared with {first.name}", _head(first.column, first.name), rows, note=note)


def _head(column: str, other: str) -> tuple[str, ...]:
    name = NAMES.get(column, column)
    measured = name, f"{name} of {other}", "difference", "95 % interval"
    return "run", "tracker", "sequences", *measured, "won"


def _row(run: SavedScores, tracker: str, ours: Floats, theirs: Floats) -> Row:
    """Return the row of a tracker's values against those of another on the same sequences."""
    sign = sign_of(run.column)
    won = int(np.count_nonzero(sign * ours > sign * theirs))
    return (
        *(Cell(run.name), Cell(short_name(tracker)), Cell(str(ours.size), ours.size)),
        *map(number, (_mean(ours), _mean(theirs))),
        *difference(paired_difference(ours, theirs)),
        Cell(f"{won} of {ours.size}", won),
    )


def _mean(values: Floats) -> float:
    return float(values.mean()) if values.size else math.nan


def optimism(first: SavedScores, others: Iterable[SavedScores], reference: str) -> Table:
    """Return a table of how much less trackers have on other sequences, beyond the reference.

    The optimism of a tracker is the mean of its lead over the reference on the sequences of the
    first run, minus the mean of its lead on those of the other.
    """
    rows: list[Row] = []
    against = tracker_named(first, reference)
    for run in others:
        if _common(first, run):
            continue
        for tracker in first.values:
            if tracker == against or tracker not in run.values:
                continue
            here = pairs(first, tracker, first, against)
            there = pairs(run, tracker, run, tracker_named(run, reference))
            leads = here[0] - here[1], there[0] - there[1]
            found = unpaired_difference(*leads)
            drops = (_mean(here[side]) - _mean(there[side]) for side in (0, 1))
            cells = (*map(number, drops), *difference(found))
            rows.append((Cell(run.name), Cell(short_name(tracker)), *cells))
    name = NAMES.get(first.column, first.column)
    side = "positive" if sign_of(first.column) > 0 else "negative"
    return Table(
        f"Optimism of {first.name}",
        (
            "checked on",
            "tracker",
            f"{name} less there",
            f"of {reference}",
            "optimism",
            "95 % interval",
        ),
        rows,
        note=(
            f"How much lower the mean {name} is on the sequences of the other run, the same of "
            f"{reference}, which nothing was chosen for, and the difference. A tracker whose "
            f"values were chosen on the first set has a {side} optimism. The interval is a "
            "bootstrap over sequences, those of each set drawn from itself."
        ),
    )
