"""Scores of a pass over a sequence, and the files of scores."""

from __future__ import annotations

import csv
import io
from abc import ABC, abstractmethod
from collections.abc import Iterable, Mapping, Sequence as Many
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any, Generic, NamedTuple, Self, TypeVar

import numpy as np
from numpy.typing import NDArray

from motes import FormatError
from motes.core import Floats, guarded, iou, write_whole, writing
from motes_lab.datasets.sot import Sequence
from motes_lab.metrics import sot as metrics
from motes_lab.protocols.trace import TrackerOutput, load_trace
from motes_lab.runner import Job, Pass

Scores = dict[str, float | int | None]
S = TypeVar("S")
T = TypeVar("T")

MISS_IOU = 0.1
"""With an overlap (IoU) below this, the tracker has lost the target."""

CORRECT_IOU = 0.5
"""With an overlap (IoU) above this, a frame is correct; the confidence is compared with that."""

PROTOCOL_NAMES = {
    "ope": "One pass (OPE)",
    "pixel": "Starts moved by a pixel",
    "mot": "All objects (MOT)",
}
"""The titles of the protocols, in the order of reports."""

COLUMNS = (
    *("tracker", "sequence", "protocol", "start", "seed", "frames"),
    *("auc", "precision_20", "iou", "od", "lost_frame"),
    *("lost_recall", "lost_precision", "lost_f1", "ece"),
    *("losses", "recovered", "coverage"),
    *("ms_median", "ms_95", "fps", "error"),
)
"""The columns of results.csv; see `score`."""

COUNTS = ("judged", "missed", "reported", "both", "known", "covered", "lost_track")
"""Numbers of frames in `score` beside the columns, of which shares are over all passes together:
`judged` are compared with the truth, in `missed` of them the target is lost, in `reported` the
tracker says so, in `both` rightly; `known` have a covariance, `covered` are in its 95 % ellipse.
`lost_track` is 1 if the track is lost in any frame."""


class Fit(NamedTuple):
    """A trace compared with the truth."""

    overlaps: Floats
    """(n,), IoU of the boxes; NaN without a target."""
    distances: Floats
    """(n,), distances between the centers of the boxes, in pixels; NaN without a target, infinite
    if the tracker gave no region."""
    covered: Floats
    """(n,), 1 if the truth's center lies in the 95 % ellipse of the tracker's position, else 0; NaN
    without a target, at the start, and if the tracker is lost or gives no covariance."""

    @property
    def present(self) -> NDArray[np.bool_]:
        """Whether there is a target, (n,)."""
        return np.isfinite(self.overlaps)

    @property
    def missed(self) -> NDArray[np.bool_]:
        """Whether the tracker has lost the target, or there is none, (n,)."""
        return ~(self.overlaps >= MISS_IOU)

    @property
    def correct(self) -> NDArray[np.bool_]:
        """Whether the overlap is large enough for a correct frame, (n,)."""
        flags: NDArray[np.bool_] = self.overlaps > CORRECT_IOU
        return flags


def fit(trace: TrackerOutput, sequence: Sequence) -> Fit:
    """Compare a trace with the truth."""
    truths = sequence.boxes[trace.frames]
    boxes = metrics.enclosing_boxes(trace.ellipses)
    given = np.isfinite(boxes).all(axis=1)
    gaps = (boxes[:, :2] + boxes[:, 2:] / 2) - (truths[:, :2] + truths[:, 2:] / 2)
    present = np.isfinite(truths).all(axis=1)
    overlaps = iou(np.nan_to_num(boxes), np.nan_to_num(truths))
    sure = present & ~trace.lost & np.isfinite(trace.covariances).all(axis=1)
    sure[:1] = False
    return Fit(
        np.where(present, np.where(given, overlaps, 0), np.nan),
        np.where(present, np.where(given, np.hypot(*gaps.T), np.inf), np.nan),
        np.where(sure, metrics.covered(gaps, trace.covariances), np.nan),
    )


def updates(trace: TrackerOutput) -> Floats:
    """Return the running times of a trace's updates, without the start, in seconds."""
    seconds: Floats = trace.seconds[1:]
    return seconds[np.isfinite(seconds)]


def score(trace: TrackerOutput, sequence: Sequence, judged: Fit | None = None) -> Scores:
    """Return the numbers of results.csv by column, without those that name the pass, and `COUNTS`.

    A number that is not defined is None:

    - `auc`, `precision_20`, `iou`, `od`, `losses` and `recovered` without a target;
    - `lost_frame`, if the target is never lost;
    - `lost_recall`, `lost_precision` and `coverage`, if they would be a share of no frames;
    - `ece` without a confidence, and times without an update.

    Frames without a target count only for the lost status and the confidence: there, `lost` is
    right, and every confidence is wrong. The frame of the start counts like all others, except for
    the times.
    """
    judged = judged or fit(trace, sequence)
    found, present, missed = judged.overlaps, judged.present, judged.missed
    values: Scores = dict.fromkeys(COLUMNS[5:-1])
    values["frames"] = len(trace.frames)
    if present.any():
        frames = trace.frames[present]
        distances = metrics.overlap_distances(trace.ellipses[present], sequence.ellipses[frames])
        values["auc"] = metrics.success_auc(found[present])
        values["precision_20"] = float(metrics.precision_curve(judged.distances[present])[20])
        values["iou"] = float(found[present].mean())
        values["od"] = float(distances.mean())
        if (first := metrics.first_lost(distances)) is not None:
            values["lost_frame"] = int(frames[first])
        values["losses"], values["recovered"] = metrics.recoveries(present, missed, judged.correct)
    if (sure := np.isfinite(trace.confidence)).any():
        values["ece"] = metrics.calibration_error(
            trace.confidence[sure], judged.correct[sure], np.ones(np.count_nonzero(sure))
        )
    flags = (
        *(np.ones_like(missed), missed, trace.lost, trace.lost & missed),
        *(np.isfinite(judged.covered), judged.covered == 1),
    )
    counts = [int(np.count_nonzero(each)) for each in flags]
    _, lost, reported, both, known, covered = counts
    values["lost_recall"] = both / lost if lost else None
    values["lost_precision"] = both / reported if reported else None
    values["lost_f1"] = 2 * both / (reported + lost) if lost else None
    values["coverage"] = covered / known if known else None
    values |= speed(updates(trace))
    lost_track = int(values["lost_frame"] is not None)
    return values | dict(zip(COUNTS, [*counts, lost_track], strict=True))


def speed(seconds: Floats) -> Scores:
    """Return the columns of results.csv for running times (n,) of updates, in seconds."""
    if not seconds.size:
        return dict.fromkeys(("ms_median", "ms_95", "fps"))
    median, high = metrics.time_quantiles(seconds)
    fps = float(seconds.size / seconds.sum()) if seconds.sum() else None
    return {"ms_median": median, "ms_95": high, "fps": fps}


@dataclass(frozen=True, eq=False)
class PassResult(ABC, Generic[S, T]):
    """The result of a pass."""

    sequence: S
    item: Pass
    """The sequence, and the pass over it."""
    trace: T | None
    """The tracker's output; None if the pass failed."""
    error: str = ""
    """The reason of a failure, in one line."""

    @property
    @abstractmethod
    def scores(self) -> Scores:
        """The numbers of results.csv by column, without the columns that name the pass."""

    @property
    @abstractmethod
    def seconds(self) -> Floats:
        """Running times of the updates, (n,); none if the pass failed."""

    @staticmethod
    @abstractmethod
    def load(path: Path, sequence: S) -> T:
        """Read the tracker's output; raise a FormatError if that is not possible."""

    @classmethod
    def of(cls, job: Job, out: Path, errors: Mapping[Pass, str]) -> list[Self]:
        """Return the results of a job's passes that have ended.

        Parameters
        ----------
        job
            The job.
        out
            The folder of the evaluation, which holds the tracks.
        errors
            The passes that failed, with the reasons.
        """
        sequence: Any = job.sequence
        found = []
        for item in job.passes:
            if item in errors:
                found.append(cls(sequence, item, None, errors[item]))
            elif (path := item.path(out)).exists():
                try:
                    found.append(cls(sequence, item, cls.load(path, sequence)))
                except FormatError as error:
                    found.append(cls(sequence, item, None, f"{error} Delete it and --resume."))
        return found


def check_length(path: Path, found: int, frames: int) -> None:
    """Raise a FormatError unless a track has as many frames as its sequence."""
    if found != frames:
        raise FormatError(f"{path} is for {found} frames, but the sequence has {frames}.")


class Outcome(PassResult[Sequence, TrackerOutput]):
    """The result of a pass with one object."""

    @staticmethod
    def load(path: Path, sequence: Sequence) -> TrackerOutput:
        """Read a trace that must continue to the end of the sequence."""
        trace = load_trace(path)
        check_length(path, int(trace.frames[-1]) + 1, sequence.frames)
        return trace

    @property
    def seconds(self) -> Floats:
        """Running times of updates, without starts."""
        return np.zeros(0) if self.trace is None else updates(self.trace)

    @cached_property
    def fit(self) -> Fit | None:
        """The trace compared with the truth; None if the pass failed."""
        return None if self.trace is None else fit(self.trace, self.sequence)

    @cached_property
    def scores(self) -> Scores:
        """The numbers of `score`; None for each column if the pass failed."""
        if self.trace is None:
            return dict.fromkeys(COLUMNS[5:-1])
        return score(self.trace, self.sequence, self.fit)


E = TypeVar("E", bound=PassResult[Any, Any])


def in_order(outcomes: Iterable[E]) -> list[E]:
    """Sort results by tracker and sequence (first come first), protocol, start and seed."""
    outcomes = list(outcomes)
    trackers = {name: i for i, name in enumerate(dict.fromkeys(o.item.tracker for o in outcomes))}
    sequences = {name: i for i, name in enumerate(dict.fromkeys(o.item.sequence for o in outcomes))}
    protocols = list(PROTOCOL_NAMES)

    def order(outcome: E) -> tuple[int, int, int, int, str, int]:
        item = outcome.item
        start = protocols.index(item.start.protocol), item.start.frame, item.start.label
        return trackers[item.tracker], sequences[item.sequence], *start, item.seed

    return sorted(outcomes, key=order)


def write_results(out: Path, outcomes: Iterable[Outcome]) -> None:
    """Write results.csv into a folder: a row for each pass, with the `COLUMNS`.

    Numbers that are not defined are empty.

    Raises
    ------
    FormatError
        If it cannot be written.
    """
    rows = (row_of(each, COLUMNS) for each in in_order(outcomes))
    write_table(out / "results.csv", COLUMNS, rows)


def row_of(outcome: PassResult[Any, Any], columns: Many[str]) -> list[str]:
    """Return the row of a pass in results.csv."""
    item = outcome.item
    names = [item.tracker, item.sequence, item.start.protocol, item.start.label, str(item.seed)]
    numbers = (format_score(outcome.scores[name]) for name in columns[5:-1])
    return [*names, *numbers, " ".join(outcome.error.split())]


def format_score(value: float | int | None) -> str:
    """Return a number with six significant digits, an empty text for None."""
    if value is None:
        return ""
    return str(value) if isinstance(value, int) else f"{value:.6g}"


def write_table(path: Path, columns: Many[str], rows: Iterable[Many[str]]) -> None:
    """Write a CSV file; raise a FormatError if that is not possible."""
    text = io.StringIO()
    cells = ([guarded(cell) for cell in row] for row in rows)
    csv.writer(text, lineterminator="\n").writerows([columns, *cells])
    write_text(path, text.getvalue())


def write_text(path: Path, text: str) -> None:
    """Write a complete file in UTF-8; other bytes, as in file names, are escaped.

    Raises
    ------
    FormatError
        If it cannot be written.
    """
    with writing(path):
        write_whole(path, text.encode(errors="backslashreplace"))
