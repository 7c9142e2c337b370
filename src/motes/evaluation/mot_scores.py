"""What passes over videos with many objects are worth, in numbers, and results.csv of them."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from functools import cached_property, reduce
from operator import add
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from motes.evaluation.aggregate import Passes
from motes.evaluation.datasets.distractors import counted
from motes.evaluation.datasets.mot import MotSequence
from motes.evaluation.metrics.mot import Tally, tally
from motes.evaluation.protocols.mot import Tracks, load_tracks
from motes.evaluation.scores import (
    PassResult,
    Scores,
    check_length,
    digits,
    row_of,
    speed,
    write_table,
)

Floats = NDArray[np.float64]

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
}
"""Columns of results.csv, and how they are made of what was counted."""

COLUMNS = (
    *("tracker", "sequence", "protocol", "start", "seed"),
    *NUMBERS,
    *("ms_median", "ms_95", "fps", "error"),
)
COMBINED = "COMBINED"
"""In the place of a sequence's name, where all of them are counted as one."""


class CrowdOutcome(PassResult[MotSequence, Tracks]):
    """What came of a pass that followed many objects."""

    @staticmethod
    def load(path: Path, sequence: MotSequence) -> Tracks:
        """Read tracks of all the sequence's frames."""
        tracks = load_tracks(path)
        check_length(path, len(tracks.seconds), sequence.frames)
        return tracks

    @cached_property
    def tally(self) -> Tally:
        """What was counted, of a pass that did not fail."""
        assert self.trace is not None
        truth, results = counted(self.sequence.truth, self.trace.rows, self.sequence.distractors)
        return tally(truth, results, self.sequence.frames)

    @property
    def seconds(self) -> Floats:
        """Of all frames, as far as known."""
        seconds = np.zeros(0) if self.trace is None else self.trace.seconds
        return seconds[np.isfinite(seconds)]

    @property
    def scores(self) -> Scores:
        """Nothing if the pass failed."""
        if self.trace is None:
            return dict.fromkeys(COLUMNS[5:-1])
        return _scores([self])


def _scores(outcomes: list[CrowdOutcome]) -> Scores:
    """Return the numbers of results.csv of passes that did not fail, counted as one."""
    sums = _sum(outcomes)
    seconds = np.concatenate([outcome.seconds for outcome in outcomes])
    return {**{name: of(sums) for name, of in NUMBERS.items()}, **speed(seconds)}


def _sum(outcomes: list[CrowdOutcome]) -> Tally:
    return reduce(add, (outcome.tally for outcome in outcomes))


class CrowdEvaluation(Passes[CrowdOutcome]):
    """Outcomes of passes that followed many objects.

    A number over several sequences is not their mean, but made of what was counted in all of them,
    as TrackEval's combined ones are.
    """

    def per_seed(
        self, tracker: str, protocol: str, of: Any, sequences: Iterable[str] | None = None
    ) -> Floats:
        """Return a number of sequences together, (seeds, ...).

        As in `Passes`; the function is of a tally.
        """
        number: Callable[[Tally], ArrayLike] = NUMBERS[of] if isinstance(of, str) else of
        wanted = set(self.finished(tracker, protocol) if sequences is None else sequences)
        chosen = (
            [outcome for outcome in outcomes if outcome.item.sequence in wanted]
            for outcomes in self.seeds(tracker, protocol).values()
        )
        return np.array([number(_sum(outcomes)) for outcomes in chosen if outcomes], np.float64)


def write_results(out: Path, evaluation: CrowdEvaluation) -> None:
    """Write results.csv into a folder, with the `COLUMNS`: a row for each pass, and combined ones.

    These count all sequences that a tracker finished as one, and are there for each seed.

    Raises
    ------
    FormatError
        If it cannot be written.
    """
    rows = [row_of(outcome) for outcome in evaluation.outcomes]
    for tracker in evaluation.trackers:
        for protocol in evaluation.protocols:
            for seed, outcomes in evaluation.seeds(tracker, protocol).items():
                numbers = map(digits, _scores(outcomes).values())
                rows.append([tracker, COMBINED, protocol, "", str(seed), *numbers, ""])
    write_table(out / "results.csv", COLUMNS, rows)
