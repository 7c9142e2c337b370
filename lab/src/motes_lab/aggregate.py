"""Means over sequences and seeds."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Iterable
from typing import Any, Generic

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from motes.core import Floats
from motes_lab.metrics import sot as metrics
from motes_lab.metrics.mot import Errors
from motes_lab.metrics.statistics import Mean, over
from motes_lab.scores import COLUMNS, COUNTS, PROTOCOL_NAMES, E, Outcome, in_order


def ranking_column(protocol: str) -> str:
    """Return the column of results.csv by which a protocol ranks trackers."""
    return "hota" if protocol == "mot" else "auc"


LESS_IS_BETTER = {
    *("od", "lost_track", "ece", "losses", "ms_median", "ms_95", "switches", "fragmentations"),
    *("false_positives", "false_negatives", "mostly_lost"),
    *Errors._fields,
}
"""The numbers of results.csv, and of its counts, of which less is better."""


def sign_of(name: str) -> int:
    """Return 1 if more of a number of results.csv is better, -1 if less is."""
    return -1 if name in LESS_IS_BETTER else 1


class Passes(ABC, Generic[E]):
    """Results by tracker, protocol and sequence.

    Numbers of a tracker are over the sequences that it finished, which are those without a failed
    pass.

    Attributes
    ----------
    outcomes
        All results, in order.
    table
        A row for each of them: what names it, and whether it failed.
    trackers, sequences, protocols
        Their names; trackers and sequences in the order of their first results.
    """

    def __init__(self, outcomes: Iterable[E]) -> None:
        self.outcomes = in_order(outcomes)
        items = [each.item for each in self.outcomes]
        self.table = pd.DataFrame(
            {
                "tracker": [item.tracker for item in items],
                "protocol": [item.start.protocol for item in items],
                "sequence": [item.sequence for item in items],
                "start": [item.start.label for item in items],
                "seed": [item.seed for item in items],
                "failed": [each.trace is None for each in self.outcomes],
                "outcome": self.outcomes,
            }
        )
        self.trackers: list[str] = self.table.tracker.unique().tolist()
        self.sequences: list[str] = self.table.sequence.unique().tolist()
        self.protocols = [name for name in PROTOCOL_NAMES if name in set(self.table.protocol)]

    def _of(self, tracker: str, protocol: str) -> Any:
        return self.table[(self.table.tracker == tracker) & (self.table.protocol == protocol)]

    def attempted(self, tracker: str, protocol: str) -> list[str]:
        """Return the sequences on which a tracker was run."""
        names: list[str] = self._of(tracker, protocol).sequence.unique().tolist()
        return names

    def finished(self, tracker: str, protocol: str) -> list[str]:
        """Return the sequences that a tracker finished."""
        rows = self._of(tracker, protocol)
        failed = set(rows.sequence[rows.failed])
        return [name for name in self.attempted(tracker, protocol) if name not in failed]

    def passes(self, tracker: str, protocol: str, sequences: Iterable[str] | None = None) -> Any:
        """Return the rows of `table` for the sequences that a tracker finished, or some of them."""
        rows, finished = self._of(tracker, protocol), self.finished(tracker, protocol)
        wanted = finished if sequences is None else set(finished).intersection(sequences)
        return rows[rows.sequence.isin(wanted)]

    def seconds(self, tracker: str, protocol: str) -> Floats:
        """Return the running times of all updates, (n,)."""
        passes = self.passes(tracker, protocol)
        return np.concatenate([[], *(outcome.seconds for outcome in passes.outcome)])

    @abstractmethod
    def per_seed(
        self, tracker: str, protocol: str, column: str, sequences: Iterable[str] | None = None
    ) -> Floats:
        """Return a number for the sequences that a tracker finished, (seeds,).

        Parameters
        ----------
        tracker, protocol
            Names of the tracker and the protocol.
        column
            A column of results.csv.
        sequences
            Only these sequences; by default all.
        """

    def mean(
        self, tracker: str, protocol: str, column: str, sequences: Iterable[str] | None = None
    ) -> Mean:
        """Return mean and standard deviation over seeds of `per_seed`."""
        return over(self.per_seed(tracker, protocol, column, sequences))


class Evaluation(Passes[Outcome]):
    """Results of passes with one object; the table has their scores and counts too.

    A mean is taken over the starts of each sequence, then over sequences, then over seeds.
    """

    def __init__(self, outcomes: Iterable[Outcome]) -> None:
        super().__init__(outcomes)
        numbers = [each.scores for each in self.outcomes]
        columns = [*COLUMNS[5:-1], *COUNTS]
        self.table = self.table.join(pd.DataFrame(numbers, columns=columns, dtype=float))

    def per_seed(
        self, tracker: str, protocol: str, column: str, sequences: Iterable[str] | None = None
    ) -> Floats:
        """Return means over starts and sequences, (seeds,); NaN where no pass has a number."""
        rows = self.passes(tracker, protocol, sequences)
        means = rows.groupby(["seed", "sequence"])[column].mean().groupby("seed").mean()
        array: Floats = means.to_numpy(float)
        return array

    def lost_f1(self, tracker: str, protocol: str) -> Mean:
        """Return F1 of the reported losses; each seed over the frames of all passes."""
        sums = self.sums(tracker, protocol)
        return over((2 * sums.both / (sums.missed + sums.reported)).where(sums.missed > 0))

    def share(self, tracker: str, protocol: str, part: str, whole: str) -> Mean:
        """Return the share of one number of `COUNTS` in another, over all passes of a seed."""
        sums = self.sums(tracker, protocol)
        return over(sums[part] / sums[whole])

    def sums(self, tracker: str, protocol: str) -> Any:
        """Return the sums of numbers over the passes of each seed, a row for each seed."""
        return self.passes(tracker, protocol).groupby("seed").sum(numeric_only=True)

    def calibration(self, tracker: str, protocol: str) -> Mean:
        """Return the calibration error, each seed's over all sequences; NaN without confidence.

        Each pass counts equally, whatever its length.
        """
        seeds = self.passes(tracker, protocol).groupby("seed").outcome
        return over(_calibration_error(outcomes) for _, outcomes in seeds)


def _calibration_error(outcomes: Iterable[Outcome]) -> float:
    columns: list[tuple[Floats, NDArray[np.bool_], Floats]] = []
    for outcome in outcomes:
        assert outcome.fit is not None
        assert outcome.trace is not None
        confidence = outcome.trace.confidence
        if (sure := np.isfinite(confidence)).any():
            weights = np.full(np.count_nonzero(sure), 1 / np.count_nonzero(sure))
            columns.append((confidence[sure], outcome.fit.correct[sure], weights))
    if not columns:
        return np.nan
    return metrics.calibration_error(*map(np.concatenate, zip(*columns, strict=True)))
