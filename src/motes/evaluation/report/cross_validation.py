"""Choosing one of several configurations without reporting it where it was chosen."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import NamedTuple

import numpy as np

from motes.evaluation.aggregate import Evaluation, ranking_column
from motes.evaluation.report.sections import NAMES
from motes.evaluation.report.tables import Cell, Row, Table, number

Values = Mapping[str, Mapping[str, float]]
"""Numbers of trackers on sequences, by their names; more is better."""


class Fold(NamedTuple):
    """A fold of the sequences, and the candidate that is best on the others.

    Attributes
    ----------
    sequences
        Those of the fold, which are left out of the choice.
    chosen
        The candidate with the highest mean over all other sequences, the first of equals.
    inside, outside
        Its means over the sequences that it was chosen on, and over those left out.
    """

    sequences: list[str]
    chosen: str
    inside: float
    outside: float


def split(sequences: Iterable[str], folds: int) -> list[list[str]]:
    """Return so many folds of sequences: in the order of their names, number i is in i mod K."""
    ordered = sorted(sequences)
    return [ordered[i::folds] for i in range(folds)]


def choose(values: Values, folds: int) -> list[Fold]:
    """Return what is chosen for each of so many folds, 2 or more.

    `values` are of the candidates, all on the same sequences, at least as many as folds. Stone,
    Cross-validatory choice and assessment of statistical predictions, JRSS B 1974.
    """
    found = []
    for fold in split(next(iter(values.values())), folds):
        inside = {
            candidate: float(np.mean([value for name, value in of.items() if name not in fold]))
            for candidate, of in values.items()
        }
        chosen = max(inside, key=inside.__getitem__)
        found.append(Fold(fold, chosen, inside[chosen], _mean(values[chosen], fold)))
    return found


def _mean(values: Mapping[str, float], names: Iterable[str]) -> float:
    """Return a mean over sequences; NaN where one has no number."""
    return float(np.mean([values.get(name, np.nan) for name in names]))


def choices(evaluation: Evaluation, protocol: str, candidates: Iterable[str], folds: int) -> Table:
    """Return a table with a row for each fold: what is chosen on the others, and what it is worth.

    The other trackers stand beside it, with their means over the sequences of the fold.
    """
    name = NAMES[ranking_column(protocol)]
    values = {
        tracker: {
            sequence: evaluation.mean(tracker, protocol, ranking_column(protocol), [sequence]).mean
            for sequence in evaluation.finished(tracker, protocol)
        }
        for tracker in evaluation.trackers
    }
    ours = [tracker for tracker in evaluation.trackers if tracker in set(candidates)]
    common = [
        sequence
        for sequence in evaluation.sequences
        if ours and all(np.isfinite(values[who].get(sequence, np.nan)) for who in ours)
    ]
    title = f"Chosen on the other folds, {folds} in all"
    if len(common) < folds:
        note = f"There are too few sequences, {len(common)}, that all configurations finished."
        return Table(title, (), [], note=note)
    found = choose({who: {s: values[who][s] for s in common} for who in ours}, folds)
    peers = [tracker for tracker in evaluation.trackers if tracker not in ours]
    theirs = [[_mean(values[peer], fold.sequences) for peer in peers] for fold in found]
    rows: list[Row] = [
        (
            Cell(str(i), i),
            Cell(str(len(fold.sequences)), len(fold.sequences)),
            Cell(fold.chosen),
            *map(number, (fold.inside, fold.outside, fold.outside - fold.inside, *means)),
        )
        for i, (fold, means) in enumerate(zip(found, theirs, strict=True), 1)
    ]
    inside, outside = (np.mean([fold[column] for fold in found]) for column in (2, 3))
    means = (inside, outside, outside - inside, *np.mean(theirs, axis=0))
    foot = (Cell("mean"), Cell(str(len(common)), len(common)), Cell(""), *map(number, means))
    return Table(
        title,
        (
            "fold",
            "sequences",
            "chosen",
            f"{name} chosen on",
            f"{name} left out",
            "difference",
            *peers,
        ),
        rows,
        (foot,),
        f"For each fold, the one of {len(ours)} configurations with the best mean {name} on all "
        f"other folds, and its mean on those and on this fold. The last line is the mean over "
        f"folds: what was left out says what to expect of a choice among these configurations. Of "
        f"the sequences that all of them finished, in the order of their names, each goes to the "
        f"next fold.",
    )
