"""Scores of passes with many objects, and their results.csv."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from functools import cached_property, reduce
from operator import add, attrgetter
from pathlib import Path

import numpy as np

from motes.core import Floats
from motes_lab.aggregate import Passes
from motes_lab.datasets.distractors import evaluated_rows
from motes_lab.datasets.mot import MotSequence
from motes_lab.metrics.mot import Errors, Tally, tally
from motes_lab.protocols.mot import Tracks, load_tracks
from motes_lab.scores import (
    PassResult,
    Scores,
    check_length,
    format_score,
    row_of,
    speed,
    write_table,
)

NUMBERS: dict[str, Callable[[Tally], float | int]] = {
    "frames": lambda t: t.frames,
    "objects": lambda t: t.objects,
    "boxes": lambda t: t.truths,
    "hota": lambda t: float(t.hota.mean()),
    "deta": lambda t: float(t.deta.mean()),
    "assa": lambda t: float(t.assa.mean()),
    "loca": lambda t: float(t.loca.mean()),
    "mota": lambda t: t.mota,
    "motp": lambda t: t.motp,
    "idf1": lambda t: t.idf1,
    "idp": lambda t: t.idp,
    "idr": lambda t: t.idr,
    "switches": lambda t: t.switches,
    "fragmentations": lambda t: t.fragmentations,
    "false_positives": lambda t: t.false_positives,
    "false_negatives": lambda t: t.false_negatives,
    "mostly_tracked": lambda t: t.mostly_tracked,
    "mostly_lost": lambda t: t.mostly_lost,
    **{name: attrgetter(name) for name in Errors._fields},
}
"""Columns of results.csv, and how they are computed from a tally."""

COLUMNS = (
    *("tracker", "sequence", "protocol", "start", "seed"),
    *NUMBERS,
    *("ms_median", "ms_95", "fps", "error"),
)
COMBINED = "COMBINED"
"""Stands in place of the sequence's name in rows that count all sequences as one."""


class MotOutcome(PassResult[MotSequence, Tracks]):
    """The result of a pass with many objects."""

    @staticmethod
    def load(path: Path, sequence: MotSequence) -> Tracks:
        """Read tracks that must cover all frames of the sequence."""
        tracks = load_tracks(path)
        check_length(path, len(tracks.seconds), sequence.frames)
        return tracks

    @cached_property
    def tally(self) -> Tally:
        """The counts of a pass that did not fail."""
        assert self.trace is not None
        truth, results = evaluated_rows(
            self.sequence.truth, self.trace.rows, self.sequence.distractors
        )
        return tally(truth, results, self.sequence.frames)

    @property
    def seconds(self) -> Floats:
        """Running times of all frames, as far as known."""
        seconds = np.zeros(0) if self.trace is None else self.trace.seconds
        return seconds[np.isfinite(seconds)]

    @property
    def scores(self) -> Scores:
        """The numbers of results.csv; None for each column if the pass failed."""
        if self.trace is None:
            return dict.fromkeys(COLUMNS[5:-1])
        return _scores([self])


def _scores(outcomes: Iterable[MotOutcome]) -> Scores:
    """Return the numbers of results.csv for passes that did not fail, counted as one."""
    sums = _sum(outcomes)
    seconds = np.concatenate([outcome.seconds for outcome in outcomes])
    return {**{name: quantity(sums) for name, quantity in NUMBERS.items()}, **speed(seconds)}


def _sum(outcomes: Iterable[MotOutcome]) -> Tally:
    return reduce(add, (outcome.tally for outcome in outcomes))


class MotEvaluation(Passes[MotOutcome]):
    """Results of passes with many objects.

    A number over several sequences is not the mean of their numbers. It is computed from the counts
    of all of them together, like the combined numbers of TrackEval.
    """

    def per_seed(
        self, tracker: str, protocol: str, column: str, sequences: Iterable[str] | None = None
    ) -> Floats:
        """Return a number for several sequences together, (seeds,), as in `Passes`."""
        seeds = self.passes(tracker, protocol, sequences).groupby("seed").outcome
        return np.array([NUMBERS[column](_sum(outcomes)) for _, outcomes in seeds], np.float64)


def write_results(out: Path, evaluation: MotEvaluation) -> None:
    """Write results.csv into a folder: a row for each pass with the `COLUMNS`, and combined rows.

    A combined row counts all sequences that a tracker finished as one; there is one for each seed.

    Raises
    ------
    FormatError
        If it cannot be written.
    """
    rows = [row_of(outcome, COLUMNS) for outcome in evaluation.outcomes]
    for tracker in evaluation.trackers:
        for protocol in evaluation.protocols:
            for seed, outcomes in evaluation.passes(tracker, protocol).groupby("seed").outcome:
                numbers = map(format_score, _scores(outcomes).values())
                rows.append([tracker, COMBINED, protocol, "", str(seed), *numbers, ""])
    write_table(out / "results.csv", COLUMNS, rows)
