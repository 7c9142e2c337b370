"""Files of tracks, in CSV or JSON Lines, with a row for each frame.

Rows are written one by one. Numbers have fixed digits and are never NaN or infinite, so equal runs
give equal bytes. This makes it possible to continue an interrupted file: the run is repeated, and
the existing rows are compared instead of written.
"""

from __future__ import annotations

import contextlib
import math
import os
import sys
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import BinaryIO, Literal, Self

import numpy as np

from motes.core.errors import ConfigError, FormatError
from motes.core.files import open_rows, write_all
from motes.core.track import Status, Track

Form = Literal["csv", "jsonl"]
FORMS: dict[str, Form] = {".csv": "csv", ".jsonl": "jsonl"}
"""The form of each file ending."""

COLUMNS = (
    "frame",
    "time",
    "x",
    "y",
    "a",
    "b",
    "theta",
    "confidence",
    "status",
    "distance",
    "effective_sample_size",
)
DEVIATIONS = ("x_std", "y_std", "a_std", "b_std", "theta_std")
"""Columns of standard deviations, in the order of an ellipse."""
GROUND = ("x_m", "y_m", "x_m_std", "y_m_std", "speed", "speed_std")
"""Columns of places in metres and speeds in metres per second."""
CORRECTED = (*COLUMNS, *DEVIATIONS, "outlier")
"""The columns of tracks that are known in hindsight: smoothed or corrected ones."""


def form_of(path: str | Path, form: Form | None = None) -> Form:
    """Return the form of a file: `form` if given, else that of the file's ending; `-` is CSV.

    Raises
    ------
    ConfigError
        If the ending is unknown.
    """
    if form is not None:
        return form
    if str(path) == "-":
        return "csv"
    ending = Path(path).suffix.lower()
    if ending not in FORMS:
        raise ConfigError(f"{path} ends neither in .csv nor in .jsonl; rename it or give a format.")
    return FORMS[ending]


def check_writable(path: str | Path, overwrite: bool = False) -> None:
    """Check that a file can be made at `path`; an existing device or pipe is allowed.

    Raises
    ------
    FormatError
        If a file exists and must not be overwritten, or the folder is missing or protected.
    """
    path = Path(path)
    if path.is_dir():
        raise FormatError(f"{path} is a folder; give the name of a file.")
    if path.is_file() and not overwrite:
        raise FormatError(f"{path} exists; choose another name, or overwrite it (--overwrite).")
    if not path.parent.is_dir():
        raise FormatError(f"There is no folder {path.parent} for {path.name}; make it first.")
    if not os.access(path if path.exists() else path.parent, os.W_OK):
        raise FormatError(f"{path} cannot be written: no permission; choose another place.")


def check_not_deleted(file: BinaryIO, path: str | Path) -> None:
    """Check that the file that is being written has not been deleted.

    Raises
    ------
    FormatError
        If it was deleted, or another file has its name now; further rows would be lost.
    """
    opened = os.fstat(file.fileno())
    if opened.st_nlink or (os.path.exists(path) and os.path.samestat(opened, os.stat(path))):
        return
    raise FormatError(f"{path} was deleted while it was written, with all that was in it.")


class TrackWriter:
    """Write tracks, a row for each frame; use it as a context manager.

    The columns are `COLUMNS`, in pixels, radians and seconds as in `Track`. A frame without a track
    has empty fields (CSV) or null (JSON Lines) and the status `searching`. The file is made with
    the first row; a row is in the file when `write` returns.

    Parameters
    ----------
    path
        The file, or `-` for standard output.
    form
        `csv` or `jsonl`; by default that of the file's ending, and `csv` for `-`.
    overwrite
        Whether an existing file may be replaced.
    resume
        Whether an existing file is the beginning of these rows. Each existing row is compared with
        the new one; a last line that was cut off is completed.
    columns
        The columns: `COLUMNS`, perhaps with `GROUND`; or `CORRECTED` for tracks that are smoothed
        or corrected.

    Attributes
    ----------
    form
        The form of the file.
    resumed
        Number of rows that existed before.
    rows
        Number of rows so far, including those.

    Raises
    ------
    ConfigError
        If the ending is unknown, or standard output is to be resumed.
    FormatError
        When it is created, if the file exists or cannot be written. Later, if the disk is full,
        the file was deleted or an existing row differs. Rows written before stay.
    """

    def __init__(
        self,
        path: str | Path,
        form: Form | None = None,
        *,
        overwrite: bool = False,
        resume: bool = False,
        columns: Sequence[str] = COLUMNS,
    ) -> None:
        self._columns = tuple(columns)
        self.form = form_of(path, form)
        self.rows = self.resumed = 0
        self._name = "Standard output" if str(path) == "-" else str(path)
        self._path = None if str(path) == "-" else Path(path)
        self._file: BinaryIO | None = None
        self._old: BinaryIO | None = None
        self._size = 0
        self._overwrite = overwrite
        if self._path is None:
            if resume:
                raise ConfigError("Standard output cannot be resumed; write the rows to a file.")
            return
        check_writable(self._path, overwrite or resume)
        if resume and self._path.exists():
            if not self._path.is_file():
                raise ConfigError(f"{path} is not an ordinary file and cannot be resumed.")
            try:
                self._old = self._path.open("rb")
            except OSError as error:
                raise self._failure(error) from error

    def write(
        self,
        frame: int,
        time: float,
        track: Track | None,
        further: Mapping[str, float | None] = {},
    ) -> None:
        """Write the row of a frame: its index, its time in seconds, and its track or None.

        Columns that a track does not have are taken from `further`; others stay empty.
        """
        if not self.rows and self.form == "csv":
            self._put(",".join(self._columns), "its first line")
        fields = fields_of(frame, time, track, self._columns, further)
        line = line_of(self.form, self._columns, fields)
        self._put(line, f"the row of frame {frame}")
        self.rows += 1
        self.resumed += self._old is not None

    def _put(self, text: str, what: str) -> None:
        """Compare a line with the existing one, or write it."""
        line = text.encode() + b"\n"
        if self._old is not None:
            existing = self._old.readline()
            if existing == line:
                self._size += len(line)
                return
            if not line.startswith(existing):
                raise FormatError(
                    f"{self._name} cannot be resumed: {what} differs, so the source, the options "
                    f"or the seed are not the same; repeat them, or write to another file."
                )
            self._old.close()
            self._old = None
            # The existing line was cut off: it is the beginning of this one, which replaces it.
            self._open("r+b")
        elif self._file is None:
            self._open("wb")
        try:
            self._write(line)
        except BrokenPipeError:  # the reader of the pipe has stopped; that is no failure
            raise
        except OSError as error:
            raise self._failure(error) from error

    def _open(self, mode: Literal["r+b", "wb"]) -> None:
        try:
            # Without a buffer, closing the file has nothing left to write and cannot fail again.
            if self._path is None:
                self._file = os.fdopen(sys.stdout.fileno(), "wb", buffering=0, closefd=False)
                return
            if mode == "wb":
                self._file = open_rows(self._path, self._overwrite)
                return
            self._file = self._path.open(mode, buffering=0)
            self._file.seek(self._size)
        except OSError as error:
            raise self._failure(error) from error

    def _write(self, line: bytes) -> None:
        assert self._file is not None
        if self._path is not None:
            check_not_deleted(self._file, self._path)
        try:
            write_all(self._file, line)
        except OSError:
            with contextlib.suppress(OSError):  # leave only complete rows, if possible
                self._file.truncate(self._size)
            raise
        self._size += len(line)

    def _failure(self, error: OSError) -> FormatError:
        return FormatError(
            f"{self._name} cannot be written: {error.strerror}; make room, or choose another "
            f"place. The {self.rows} rows so far are kept."
        )

    def close(self) -> None:
        """Close the file.

        Raises
        ------
        FormatError
            If a resumed file has more rows than this run wrote; they stay.
        """
        more = self._old is not None and self._old.read(1)
        self._release()
        if more:
            raise FormatError(
                f"{self._name} cannot be resumed: it holds more than the {self.rows} rows of this "
                f"run, so the source or the options are not the same; write to another file."
            )

    def _release(self) -> None:
        for file in (self._old, self._file):
            if file is not None:
                file.close()
        self._old = self._file = None

    def __enter__(self) -> Self:
        return self

    def __exit__(self, kind: type[BaseException] | None, *_: object) -> None:
        if kind is None:
            self.close()
        else:
            self._release()


def fields_of(
    frame: int,
    time: float,
    track: Track | None,
    columns: Sequence[str] = COLUMNS,
    further: Mapping[str, float | None] = {},
) -> list[str]:
    """Return the fields of a frame's row, as text; most are empty without a track.

    Columns that a track does not have are taken from `further`.
    """
    fields = {"frame": str(frame), "time": _number(time, 6), "status": str(Status.SEARCHING)}
    if track is not None:
        for name, value in zip(("x", "y", "a", "b"), track.ellipse, strict=False):
            fields[name] = _number(value, 3)
        fields["theta"] = _number(track.ellipse.theta, 5)
        fields["confidence"] = _number(track.confidence, 5)
        fields["status"] = str(track.status)
        fields["distance"] = _number(track.distance, 5)
        fields["effective_sample_size"] = _number(track.effective_sample_size, 2)
    if track is not None and "outlier" in columns:
        deviations = np.sqrt(track.covariance.diagonal()).tolist()
        fields |= {n: _number(value, 5) for n, value in zip(DEVIATIONS, deviations, strict=True)}
        fields["outlier"] = str(int(track.outlier))
    known = {name: value for name, value in further.items() if value is not None}
    fields |= {name: _number(value, 5) for name, value in known.items()}
    return [fields.get(name, "") for name in columns]


def line_of(form: Form, columns: Sequence[str], fields: Sequence[str]) -> str:
    """Return the fields of a row as a line; an empty one is null in JSON."""
    if form == "csv":
        return ",".join(fields)
    pairs = zip(columns, fields, strict=True)
    return "{" + ", ".join(f'"{key}": {_json(key, text)}' for key, text in pairs) + "}"


def _number(value: float, digits: int) -> str:
    """Return a number with fixed digits, zero without a sign; empty text if it is not finite."""
    return f"{value:z.{digits}f}" if math.isfinite(value) else ""


def _json(key: str, text: str) -> str:
    return f'"{text}"' if key == "status" else text or "null"
