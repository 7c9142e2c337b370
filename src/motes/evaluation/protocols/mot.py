"""How a tracker of many objects is put to the test: one pass over all frames, and what is noted."""

from __future__ import annotations

import csv
import io
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from motes.core.detection import Detection
from motes.core.errors import FormatError
from motes.core.files import write_whole
from motes.core.frame import Frame
from motes.evaluation.adapters.mot import Info, MotTrackerAdapter
from motes.evaluation.datasets.mot import MotSequence
from motes.evaluation.datasets.mot_files import UNKNOWN, Rows, read_rows, rows_of, write_rows
from motes.evaluation.protocols.trace import duration

COLUMNS = ("frame", "objects", "seconds")
"""Of the file beside the rows: frames from 0, how many objects were said, in what time."""


@dataclass(frozen=True, slots=True, eq=False)
class Tracks:
    """What a tracker said in one pass.

    Attributes
    ----------
    rows
        Where it said objects are.
    seconds
        (frames,), of time inside the tracker; NaN where that is not known.
    """

    rows: Rows
    seconds: NDArray[np.float64]


class MotPass:
    """A pass in progress: hand it every frame of the film in order, then take its tracks.

    Parameters
    ----------
    begin
        Makes who is tested.
    crowd
        Where.
    """

    def __init__(self, begin: Callable[[], MotTrackerAdapter], crowd: MotSequence) -> None:
        self._begin, self._crowd = begin, crowd
        self._follower: MotTrackerAdapter | None = None
        self._lines: list[list[float]] = []
        self._seconds: list[float] = []

    def feed(self, frame: Frame) -> None:
        """Take the next frame."""
        crowd = self._crowd
        if self._follower is None:
            self._follower = self._begin()
            info = Info(crowd.name, crowd.frames, crowd.rate, frame.width, frame.height)
            self._follower.start(info)
        detections = None
        if crowd.detections is not None:
            known = crowd.detections.listed(frame.index)
            detections = [Detection(box, score) for _, box, score in known]
        said = self._follower.update(frame, detections)
        for identity, (x, y, width, height), score in said.found:
            line = [frame.index + 1, identity, x + 1, y + 1, width, height, score, UNKNOWN]
            self._lines.append(line)
        self._seconds.append(said.seconds)

    def close(self) -> None:
        """Let go of the contestant."""
        if self._follower is not None:
            self._follower.close()

    @property
    def tracks(self) -> Tracks:
        """What was said so far."""
        return Tracks(rows_of(self._lines), np.array(self._seconds, np.float64))

    def save(self, path: Path) -> None:
        """Write the tracks, as `save_tracks` does."""
        save_tracks(path, self.tracks)


def save_tracks(path: Path, tracks: Tracks) -> None:
    """Write times as CSV with the `COLUMNS`, and first, beside them, the rows as .txt.

    Raises
    ------
    FormatError
        If that is not possible; there is no CSV then.
    """
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(COLUMNS)
    counts = np.bincount(tracks.rows.frames, minlength=len(tracks.seconds) + 1)[1:]
    for index, (count, seconds) in enumerate(
        zip(counts.tolist(), tracks.seconds.tolist(), strict=True)
    ):
        writer.writerow([index, count, repr(seconds) if seconds == seconds else ""])
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        write_rows(path.with_suffix(".txt"), tracks.rows)
        write_whole(path, text.getvalue().encode())
    except OSError as error:
        raise FormatError(
            f"{path} cannot be written: {error.strerror}; make room, or choose another place."
        ) from None


def load_tracks(path: Path) -> Tracks:
    """Read tracks that `save_tracks` wrote.

    Raises
    ------
    FormatError
        If one of the files cannot be read or is something else.
    """
    try:
        head, *lines = csv.reader(io.StringIO(path.read_text(encoding="utf-8")))
        if tuple(head) != COLUMNS:
            raise ValueError("its columns are others")
        seconds = np.array([duration(line[2]) for line in lines])
        return Tracks(read_rows(path.with_suffix(".txt"), len(seconds), "results"), seconds)
    except OSError as error:
        raise FormatError(f"{error.filename} cannot be read: {error.strerror}.") from None
    except (ValueError, IndexError, csv.Error) as error:
        raise FormatError(f"{path} is not a track of an evaluation ({error}).") from None
