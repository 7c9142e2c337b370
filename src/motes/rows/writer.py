"""Rows into a file, one by one, in CSV or JSON Lines.

An interrupted file can be continued: the run is repeated, and the existing rows are compared
instead of written.
"""

from __future__ import annotations

import contextlib
import math
import os
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Any, BinaryIO, Literal, Self

import msgspec
from msgspec.structs import replace

from motes.core.errors import ConfigError, FormatError
from motes.core.files import check_writable, open_rows, write_all
from motes.core.frame import NUMBER, WHOLE
from motes.core.track import COLUMNS, Track
from motes.rows.schema import HINDSIGHT, Form, FrameRow, Header, form_of, head, line


def appeared(path: str | Path) -> FormatError:
    """Return the error of a file that was not there when the run began."""
    return FormatError(
        f"{path} has appeared since this run began, so another run writes it; give each its own "
        f"file."
    )


def check_not_deleted(file: BinaryIO, path: str | Path) -> None:
    """Check that the file that is being written has not been deleted.

    Raises a FormatError if it was deleted, or another file has its name now; further rows would be
    lost.
    """
    opened = os.fstat(file.fileno())
    if opened.st_nlink or (os.path.exists(path) and os.path.samestat(opened, os.stat(path))):
        return
    raise FormatError(f"{path} was deleted or replaced while it was written, with all in it.")


class Lines:
    """Lines in a file or on standard output, without a buffer; use it as a context manager.

    The file is made by the first `put`, even of no line, or at the end of a run that had none.
    Lines are in the file when `put` returns. Raises a ConfigError if standard output is to be
    resumed; and a FormatError at once if the file exists or cannot be written, later if the disk is
    full, the file was deleted, or an existing line differs. Lines written before stay. A last line
    that was cut off is completed. `matched` lines existed before, and `count` includes these.
    """

    def __init__(self, name: str, overwrite: bool = False, *, resume: bool = False) -> None:
        self.name, self._path, self._overwrite = name, Path(name), overwrite
        self.count = self.matched = 0
        self._file: BinaryIO | None = None
        self._old: BinaryIO | None = None
        self._size = 0
        if name == "-":
            if resume:
                raise ConfigError("Standard output cannot be resumed; write the rows to a file.")
            return
        check_writable(name, overwrite or resume)
        if resume and self._path.exists():
            if not self._path.is_file():
                raise ConfigError(f"{name} is not an ordinary file and cannot be resumed.")
            try:
                self._old = self._path.open("rb")
            except OSError as error:
                raise self._failure(error) from error

    def put(self, lines: Sequence[str]) -> None:
        """Write lines, or compare them with the existing ones."""
        data = [text.encode() + b"\n" for text in lines]
        while data and self._old is not None:
            self._compare(self._old, data)
        if self._old is not None:
            return
        try:
            self._write(self._file or self._open("wb"), b"".join(data))
        except BrokenPipeError:  # the reader of the pipe has stopped; that is no failure
            raise
        except OSError as error:
            raise self._failure(error) from error
        self.count += len(data)

    def _compare(self, old: BinaryIO, data: list[bytes]) -> None:
        """Take the first line away if it exists; else open the file where the old ones end."""
        existing = old.readline()
        if existing == data[0]:
            self._size += len(data.pop(0))
            self.count += 1
            self.matched += 1
        elif data[0].startswith(existing):
            # The existing line was cut off: it is the beginning of this one, which replaces it.
            old.close()
            self._old = None
            self._open("r+b")
        else:
            raise FormatError(
                f"{self.name} cannot be resumed: its line {self.count + 1} differs, so the source, "
                f"the options, the seed or the version of motes are not the same; repeat them, or "
                f"write to another file."
            )

    @property
    def result(self) -> str | None:
        """The file."""
        return self.name if self._file is not None and self.name != "-" else None

    def _open(self, mode: Literal["r+b", "wb"]) -> BinaryIO:
        try:
            # Without a buffer, closing the file has nothing left to write and cannot fail again.
            if self.name == "-":
                file: BinaryIO = os.fdopen(sys.stdout.fileno(), "wb", buffering=0, closefd=False)
            elif mode == "wb":
                file = open_rows(self.name, self._overwrite)
            else:
                file = self._path.open(mode, buffering=0)
                file.seek(self._size)
        except OSError as error:
            raise self._failure(error) from error
        self._file = file
        return file

    def _write(self, file: BinaryIO, data: bytes) -> None:
        if file.closed:
            raise FormatError(f"{self.name} is closed; write to it before.")
        if self.name != "-":
            check_not_deleted(file, self.name)
        try:
            write_all(file, data)
        except OSError:
            with contextlib.suppress(OSError):  # leave only complete lines, if possible
                file.truncate(self._size)
            raise
        self._size += len(data)

    def _failure(self, error: OSError) -> FormatError:
        if isinstance(error, FileExistsError):
            return appeared(self.name)
        name = "Standard output" if self.name == "-" else self.name
        return FormatError(
            f"{name} cannot be written: {error.strerror}; make room, or choose another place. The "
            f"{self.count} lines so far are kept."
        )

    def close(self) -> None:
        """Close the file.

        Raises a FormatError if a resumed file has more lines than this run wrote; they stay.
        """
        more = self._old is not None and self._old.read(1)
        if self._file is None and self._old is None:
            self._open("wb")
        self._release()
        if more:
            raise FormatError(
                f"{self.name} cannot be resumed: it holds more than the {self.count} lines of this "
                f"run, so the source or the options are not the same; write to another file."
            )

    def _release(self) -> None:
        for file in (self._old, self._file):
            if file is not None:
                file.close()
        self._old = None

    def __enter__(self) -> Self:
        return self

    def __exit__(self, kind: type[BaseException] | None, *_: object) -> None:
        if kind is None:
            self.close()
        else:
            self._release()


class JournalWriter(Lines):
    """Make a new journal, and add the rows of frames; without any row there is no file.

    Raises a FormatError as from `Lines`.
    """

    def __init__(self, path: Path, head: Header) -> None:
        if os.path.lexists(path):
            raise appeared(path)
        super().__init__(str(path))
        try:
            self._encode(head)
        except BaseException:
            self._release()
            if self._file is not None:  # and not another program's
                path.unlink(missing_ok=True)
            raise

    def add(self, row: FrameRow) -> None:
        """Add the row of a frame."""
        self._encode(row.to_dict())

    def _encode(self, line: Header | dict[str, Any]) -> None:
        self.put([msgspec.json.encode(line).decode()])


class TrackWriter(Lines):
    """Write tracks, a row for each object in each frame; use it as a context manager.

    The columns are `COLUMNS`, in pixels, radians and seconds as in `Track`. The head is written
    with the first frame; a row is in the file when `write` returns.

    Parameters
    ----------
    path, overwrite, resume
        As in `Lines`.
    form
        `csv` or `jsonl`; by default that of the file's ending, and `csv` for `-`.
    further
        Columns after those: `HINDSIGHT` for tracks that are smoothed or corrected, `GROUND`.

    Attributes
    ----------
    form
        The form of the file.

    Raises
    ------
    ConfigError
        If the ending is unknown, or standard output is to be resumed.
    FormatError
        As from `Lines`.
    """

    def __init__(
        self,
        path: str | Path,
        form: Form | None = None,
        *,
        overwrite: bool = False,
        resume: bool = False,
        further: Sequence[str] = (),
    ) -> None:
        self.form, self._further = form_of(path, form), tuple(further)
        self._columns = (*COLUMNS, *self._further)
        self._head = head(self.form, self._columns)
        super().__init__(str(path), overwrite, resume=resume)

    @property
    def rows(self) -> int:
        """Number of rows so far, including those that existed before."""
        return max(self.count - len(self._head), 0)

    @property
    def resumed(self) -> int:
        """Number of rows that existed before."""
        return max(self.matched - len(self._head), 0)

    def write(self, frame: int, time: float, track: Track | None) -> None:
        """Write the row of one target: the frame's index, its time in seconds, its track or None.

        A frame without a track has empty fields (CSV) or null (JSON Lines) and the status
        `searching`.
        """
        numbers = isinstance(frame, WHOLE) and frame >= 0 and isinstance(time, NUMBER)
        if not (isinstance(track, Track | None) and numbers and math.isfinite(time)):
            got = f"{frame!r}, {time!r}, {track!r}"
            raise ConfigError(f"Write a frame's index, its time, and its Track; got {got}.")
        time = float(time)  # also of a fraction
        if track is None:
            row = Track.nowhere(frame, time)
        else:
            smoothed = track.smoothed or set(HINDSIGHT) <= set(self._further)
            row = replace(track, smoothed=smoothed)
        self.add(FrameRow(frame, time, (replace(row, frame=frame, time=time),)))

    def add(self, picture: FrameRow) -> None:
        """Write the rows of all objects in a frame."""
        rows = [
            line(self.form, self._columns, picture.values(each, self._further))
            for each in picture.objects
        ]
        self.put(rows if self.count else [*self._head, *rows])

    def close(self) -> None:
        """Close the file; without any frame it has only the head.

        Raises
        ------
        FormatError
            As from `Lines.close`.
        """
        if not self.count:
            self.put(self._head)
        super().close()
