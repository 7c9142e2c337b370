"""One pass of a multi-object tracker over the frames of a sequence, and its tracks."""

from __future__ import annotations

import csv
import io
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from motes import FormatError, Frame
from motes.core import write_whole, writing
from motes_lab.adapters.mot import MotTrackerAdapter, SequenceInfo
from motes_lab.datasets.mot import MotSequence
from motes_lab.datasets.mot_rows import MotRows, line_of, read_rows, rows_of
from motes_lab.protocols.trace import duration

DIGITS = 9
"""Decimals of results: enough to restore them except for rounding errors."""
COLUMNS = ("frame", "objects", "seconds")
"""The columns of the CSV file beside the rows: frames from 0, number of objects, running time."""


@dataclass(frozen=True, slots=True, eq=False)
class Tracks:
    """The output of a tracker in one pass."""

    rows: MotRows
    """The boxes with identities."""
    seconds: NDArray[np.float64]
    """(frames,), time inside the tracker; NaN where unknown."""


class MotPass:
    """A pass in progress: feed it every frame of the sequence in order, then read its tracks.

    Parameters
    ----------
    make_adapter
        Makes the tracker under test.
    sequence
        The sequence under test.
    """

    def __init__(
        self, make_adapter: Callable[[], MotTrackerAdapter], sequence: MotSequence
    ) -> None:
        self._make_adapter, self._sequence = make_adapter, sequence
        self._adapter: MotTrackerAdapter | None = None
        self._lines: list[list[float]] = []
        self._seconds: list[float] = []

    def feed(self, frame: Frame) -> None:
        """Process the next frame."""
        sequence = self._sequence
        if self._adapter is None:
            self._adapter = self._make_adapter()
            info = SequenceInfo(
                sequence.name,
                sequence.frames,
                sequence.rate,
                frame.width,
                frame.height,
                sequence.source,
            )
            self._adapter.start(info)
        known = sequence.detections
        given = None if known is None else known.detections(frame.index)
        answer = self._adapter.update(frame, given)
        self._lines += (line_of(frame.index, *found) for found in answer.found)
        self._seconds.append(answer.seconds)

    @property
    def trace(self) -> Tracks:
        """The tracks so far."""
        return Tracks(rows_of(self._lines), np.array(self._seconds, np.float64))

    def save(self, path: Path) -> None:
        """Write the tracks with `save_tracks`."""
        save_tracks(path, self.trace)


def save_tracks(path: Path, tracks: Tracks) -> None:
    """Write the rows as .txt and, after that, counts and times as CSV with the `COLUMNS`.

    Raises
    ------
    FormatError
        If a file cannot be written; there is no CSV file then.
    """
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(COLUMNS)
    counts = np.bincount(tracks.rows.frames, minlength=len(tracks.seconds) + 1)[1:]
    for index, (count, seconds) in enumerate(
        zip(counts.tolist(), tracks.seconds.tolist(), strict=True)
    ):
        writer.writerow([index, count, repr(seconds) if seconds == seconds else ""])
    with writing(path):
        path.parent.mkdir(parents=True, exist_ok=True)
        write_rows(path.with_suffix(".txt"), tracks.rows)
        write_whole(path, text.getvalue().encode())


def write_rows(path: Path, rows: MotRows) -> None:
    """Write results, complete or not at all; raise an OSError if that fails."""
    lines = []
    for frame, identity, box, score in zip(
        rows.frames.tolist(), rows.ids.tolist(), rows.boxes.tolist(), rows.scores.tolist(),
        strict=True,
    ):  # fmt: skip
        numbers = ",".join(f"{round(value, DIGITS):.15g}" for value in (*box, score))
        lines.append(f"{frame},{identity},{numbers},-1,-1,-1\n")
    write_whole(path, "".join(lines).encode())


def load_tracks(path: Path) -> Tracks:
    """Read tracks that `save_tracks` wrote.

    Raises
    ------
    FormatError
        If one of the files cannot be read or has another format.
    """
    try:
        head, *lines = csv.reader(io.StringIO(path.read_text(encoding="utf-8")))
        if tuple(head) != COLUMNS:
            raise ValueError("it has other columns")
        seconds = np.array([duration(line[2]) for line in lines])
        return Tracks(read_rows(path.with_suffix(".txt"), len(seconds), "results"), seconds)
    except OSError as error:
        raise FormatError(f"{error.filename} cannot be read: {error.strerror}.") from None
    except (ValueError, IndexError, csv.Error) as error:
        raise FormatError(f"{path} is not a track of an evaluation ({error}).") from None
