"""Means over sequences and seeds, and comparisons of trackers."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Iterable
from typing import Any, Generic, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from motes.core.types import Floats
from motes_lab.metrics import sot as metrics
from motes_lab.metrics.statistics import Mean, over
from motes_lab.scores import PROTOCOL_NAMES, E, Outcome, in_order

Quantity = Callable[[Outcome], ArrayLike]
"""A function that returns a number or an array for a pass that finished."""


class LostStatus(NamedTuple):
    """How well a tracker reports its losses, over the frames of all sequences.

    Attributes
    ----------
    missed
        Share of frames in which the target is lost.
    reported
        Share of frames in which the tracker reports a loss.
    recall, precision, f1
        See `metrics.sot.detection_recall`.
    """

    missed: Mean
    reported: Mean
    recall: Mean
    precision: Mean
    f1: Mean


class Share(NamedTuple):
    """A share of all counted items in the passes of a seed.

    Attributes
    ----------
    total
        Number of items.
    share
        The share; NaN without items.
    """

    total: Mean
    share: Mean


def ranking_column(protocol: str) -> str:
    """Return the column of results.csv by which a protocol ranks trackers."""
    return {"reset": "accuracy", "mot": "hota"}.get(protocol, "auc")


class Passes(ABC, Generic[E]):
    """Results by tracker, protocol and sequence.

    Numbers of a tracker are over the sequences that it finished, which are those without a failed
    pass.

    Attributes
    ----------
    outcomes
        All results, in order.
    trackers, sequences, protocols
        Their names; trackers and sequences in the order of their first results.
    """

    def __init__(self, outcomes: Iterable[E]) -> None:
        self.outcomes = in_order(outcomes)
        self.trackers = list(dict.fromkeys(o.item.tracker for o in self.outcomes))
        self.sequences = list(dict.fromkeys(o.item.sequence for o in self.outcomes))
        used = {o.item.start.protocol for o in self.outcomes}
        self.protocols = [protocol for protocol in PROTOCOL_NAMES if protocol in used]
        self._outcomes: dict[tuple[str, str], dict[str, list[E]]] = {
            (tracker, protocol): {} for tracker in self.trackers for protocol in self.protocols
        }
        for outcome in self.outcomes:
            item = outcome.item
            by_sequence = self._outcomes[item.tracker, item.start.protocol]
            by_sequence.setdefault(item.sequence, []).append(outcome)

    def attempted(self, tracker: str, protocol: str) -> list[str]:
        """Return the sequences on which a tracker was run."""
        return list(self._outcomes[tracker, protocol])

    def finished(self, tracker: str, protocol: str) -> list[str]:
        """Return the sequences that a tracker finished."""
        return [
            name
            for name, outcomes in self._outcomes[tracker, protocol].items()
            if all(outcome.trace is not None for outcome in outcomes)
        ]

    def passes(self, tracker: str, protocol: str) -> list[E]:
        """Return the passes over the sequences that a tracker finished."""
        by_sequence = self._outcomes[tracker, protocol]
        return [o for name in self.finished(tracker, protocol) for o in by_sequence[name]]

    def seeds(self, tracker: str, protocol: str) -> dict[int, list[E]]:
        """Return the passes of `passes` by seed."""
        by_seed: dict[int, list[E]] = {}
        for outcome in self.passes(tracker, protocol):
            by_seed.setdefault(outcome.item.seed, []).append(outcome)
        return dict(sorted(by_seed.items()))

    def seconds(
        self, tracker: str, protocol: str, sequences: Iterable[str] | None = None
    ) -> Floats:
        """Return the running times of all updates, or of those on some sequences, (n,)."""
        wanted = set(self.sequences if sequences is None else sequences)
        passes = (o for o in self.passes(tracker, protocol) if o.item.sequence in wanted)
        return np.concatenate([[], *(o.seconds for o in passes)])

    @abstractmethod
    def per_seed(
        self, tracker: str, protocol: str, quantity: Any, sequences: Iterable[str] | None = None
    ) -> Floats:
        """Return a number or an array for the sequences that a tracker finished, (seeds, ...).

        Parameters
        ----------
        tracker, protocol
            Names of the tracker and the protocol.
        quantity
            A column of results.csv, or a function.
        sequences
            Only these sequences, all of which the tracker finished; by default all.
        """

    def mean(
        self, tracker: str, protocol: str, quantity: Any, sequences: Iterable[str] | None = None
    ) -> Mean:
        """Return mean and standard deviation over seeds of `per_seed`."""
        return over(self.per_seed(tracker, protocol, quantity, sequences))


class Evaluation(Passes[Outcome]):
    """Results of passes with one object.

    A mean is taken over the starts of each sequence, then over sequences, then over seeds.
    """

    def per_seed(
        self,
        tracker: str,
        protocol: str,
        quantity: str | Quantity,
        sequences: Iterable[str] | None = None,
    ) -> Floats:
        """Return means over sequences, (seeds, ...); NaN where no pass has a number.

        As in `Passes`; the quantity is a column, or a function of the result of a pass.
        """
        wanted = set(self.finished(tracker, protocol) if sequences is None else sequences)
        means = []
        for outcomes in self.seeds(tracker, protocol).values():
            values: dict[str, list[ArrayLike]] = {}
            for outcome in outcomes:
                if outcome.item.sequence in wanted:
                    value = (
                        _column(outcome, quantity)
                        if isinstance(quantity, str)
                        else quantity(outcome)
                    )
                    values.setdefault(outcome.item.sequence, []).append(value)
            if values:
                means.append(_mean([_mean(starts) for starts in values.values()]))
        return np.array(means)

    def worst_tenth(self, tracker: str, protocol: str) -> Mean:
        """Return the mean of the lowest tenth of AUC (rounded up) among the passes of each seed."""
        lowest = []
        for outcomes in self.seeds(tracker, protocol).values():
            if (values := _aucs(outcomes)).size:
                lowest.append(values[: -(-values.size // 10)].mean())
        return over(np.array(lowest))

    def aucs(self, tracker: str, protocol: str) -> Floats:
        """Return the AUC of each pass that has one, of all seeds, in increasing order."""
        return _aucs(self.passes(tracker, protocol))

    def per_start(self, tracker: str, protocol: str, start: str) -> Mean:
        """Return the AUC of one start of a protocol: the mean over sequences, then over seeds."""

        def auc(outcome: Outcome) -> float:
            return _column(outcome, "auc") if outcome.item.start.label == start else np.nan

        return self.mean(tracker, protocol, auc)

    def lost_status(self, tracker: str, protocol: str) -> LostStatus:
        """Return how well a tracker reports its losses; each seed over the frames of all passes."""
        rows = []
        for outcomes in self.seeds(tracker, protocol).values():
            lost, missed = [], []
            for outcome in outcomes:
                assert outcome.fit is not None
                assert outcome.trace is not None
                lost.append(outcome.trace.lost[outcome.fit.rows])
                missed.append(outcome.fit.missed)
            reported, true = np.concatenate(lost), np.concatenate(missed)
            if reported.size:
                scores = (
                    metrics.detection_recall(reported, true),
                    metrics.detection_precision(reported, true),
                    metrics.detection_f1(reported, true),
                )
                rows.append((true.mean(), reported.mean(), *scores))
        return LostStatus(*map(over, np.array(rows, np.float64).reshape(-1, 5).T))

    def recovery(self, tracker: str, protocol: str) -> Share:
        """Return the number of losses, and the share after which the target was found again."""

        def count(outcome: Outcome) -> tuple[float, float]:
            return _column(outcome, "losses"), _column(outcome, "recovered")

        return self._pooled(tracker, protocol, count)

    def coverage(self, tracker: str, protocol: str) -> Share:
        """Return the number of frames with a covariance, and the share in its 95 % ellipse."""

        def count(outcome: Outcome) -> tuple[float, float]:
            assert outcome.fit is not None
            known = outcome.fit.covered[np.isfinite(outcome.fit.covered)]
            return known.size, known.sum()

        return self._pooled(tracker, protocol, count)

    def _pooled(
        self, tracker: str, protocol: str, count: Callable[[Outcome], tuple[float, float]]
    ) -> Share:
        """Return a count summed over the passes, and the share of a second count in it."""
        rows = []
        for outcomes in self.seeds(tracker, protocol).values():
            whole, part = np.nansum([count(outcome) for outcome in outcomes], axis=0)
            rows.append((whole, part / whole if whole else np.nan))
        return Share(*map(over, np.array(rows, np.float64).reshape(-1, 2).T))

    def reliability(self, tracker: str, protocol: str) -> metrics.Reliability | None:
        """Return a tracker's reliability over all passes; None if it gives no confidence.

        Each pass counts equally, whatever its length.
        """
        return _reliability(self.passes(tracker, protocol))

    def calibration(self, tracker: str, protocol: str) -> Mean:
        """Return the calibration error, each seed's over all sequences; NaN without confidence."""
        found = map(_reliability, self.seeds(tracker, protocol).values())
        return over(np.array([seed.error for seed in found if seed is not None]))


def success_curve(outcome: Outcome) -> Floats:
    """Return the success curve of a pass, (21,)."""
    assert outcome.fit is not None
    return metrics.success_curve(outcome.fit.overlaps[outcome.fit.present])


def precision_curve(outcome: Outcome) -> Floats:
    """Return the precision curve of a pass, (51,)."""
    assert outcome.fit is not None
    return metrics.precision_curve(outcome.fit.distances[outcome.fit.present])


def _column(outcome: Outcome, name: str) -> float:
    value = outcome.scores[name]
    return np.nan if value is None else float(value)


def _aucs(outcomes: Iterable[Outcome]) -> Floats:
    values = np.array([_column(outcome, "auc") for outcome in outcomes], np.float64)
    return np.sort(values[np.isfinite(values)])


def _mean(values: list[ArrayLike]) -> Floats:
    """Return the mean of arrays of one shape; each number over the values that are not NaN."""
    table = np.array(values, np.float64)
    known = np.isfinite(table)
    count = np.maximum(known.sum(axis=0), 1)
    mean: Floats = np.where(known, table, 0).sum(axis=0) / count
    return np.where(known.any(axis=0), mean, np.nan)


def _reliability(outcomes: list[Outcome]) -> metrics.Reliability | None:
    columns: list[tuple[Floats, NDArray[np.bool_], Floats]] = []
    for outcome in outcomes:
        assert outcome.fit is not None
        assert outcome.trace is not None
        confidence = outcome.trace.confidence[outcome.fit.rows]
        if (sure := np.isfinite(confidence)).any():
            weights = np.full(np.count_nonzero(sure), 1 / np.count_nonzero(sure))
            columns.append((confidence[sure], outcome.fit.correct[sure], weights))
    if not columns:
        return None
    confidence, correct, weights = (np.concatenate(column) for column in zip(*columns, strict=True))
    return metrics.reliability(confidence, correct.astype(bool), weights)
