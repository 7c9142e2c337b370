"""Model selection by cross-validation: a choice is judged on sequences not used to make it."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import NamedTuple

import numpy as np

from motes_lab.aggregate import Evaluation, ranking_column
from motes_lab.report.sections import NAMES
from motes_lab.report.tables import Cell, Row, Table, number

Values = Mapping[str, Mapping[str, float]]
"""Numbers by tracker and sequence; more is better."""


class Fold(NamedTuple):
    """A fold of the sequences, and the candidate that is best on all others.

    Attributes
    ----------
    sequences
        The sequences of the fold, which are not used for the choice.
    chosen
        The candidate with the highest mean over all other sequences, the first one among equals.
    inside, outside
        Its mean over the sequences used for the choice, and over those of the fold.
    """

    sequences: list[str]
    chosen: str
    inside: float
    outside: float


def split(sequences: Iterable[str], folds: int) -> list[list[str]]:
    """Split sequences into folds: in the order of their names, sequence i goes to fold i mod K."""
    ordered = sorted(sequences)
    return [ordered[i::folds] for i in range(folds)]


def choose(values: Values, folds: int) -> list[Fold]:
    """Return the choice for each of the folds, of which there are 2 or more.

    `values` are those of the candidates, all on the same sequences, at least as many as folds.
    Stone, Cross-validatory choice and assessment of statistical predictions, JRSS B 1974.
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
    """Return the mean over sequences; NaN if one has no number."""
    return float(np.mean([values.get(name, np.nan) for name in names]))


def choices(evaluation: Evaluation, protocol: str, candidates: Iterable[str], folds: int) -> Table:
    """Return a table of the choice made without each fold, and its score on the fold.

    The other trackers have columns with their means over the sequences of the fold.
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
        if ours and all(np.isfinite(values[tracker].get(sequence, np.nan)) for tracker in ours)
    ]
    title = f"Model selection by cross-validation, {folds} folds"
    if len(common) < folds:
        note = f"There are too few sequences, {len(common)}, that all configurations finished."
        return Table(title, (), [], note=note)
    found = choose({tracker: {s: values[tracker][s] for s in common} for tracker in ours}, folds)
    peers = [tracker for tracker in evaluation.trackers if tracker not in ours]
    peer_means = [[_mean(values[peer], fold.sequences) for peer in peers] for fold in found]
    rows: list[Row] = [
        (
            Cell(str(i), i),
            Cell(str(len(fold.sequences)), len(fold.sequences)),
            Cell(fold.chosen),
            *map(number, (fold.inside, fold.outside, fold.outside - fold.inside, *means)),
        )
        for i, (fold, means) in enumerate(zip(found, peer_means, strict=True), 1)
    ]
    inside, outside = (np.mean([fold[column] for fold in found]) for column in (2, 3))
    means = (inside, outside, outside - inside, *np.mean(peer_means, axis=0))
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
        f"For each fold: the one of {len(ours)} configurations with the best mean {name} on all "
        f"other folds, its mean on those, and its mean on this fold, which was left out. The last "
        f"line is the mean over folds; the mean on left-out folds is an estimate for a choice "
        f"among these configurations. The sequences that all of them finished are dealt to the "
        f"folds in turn, in the order of their names.",
    )
