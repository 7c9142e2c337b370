"""The outputs of several objects: rows, documents, events, an annotated video."""

from __future__ import annotations

import os
import shlex
import sys
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, BinaryIO, Literal, Protocol, Self

import msgspec

from motes.core.errors import ConfigError, FormatError
from motes.core.files import open_rows, write_all
from motes.core.frame import FRAME_INTERVAL, Frame
from motes.core.track import Status
from motes.mot.analytics.events import Event, Regions
from motes.mot.tracked_object import SceneTrack
from motes.output.documents import DOCUMENTS, is_document, write_document
from motes.output.journal import (
    FrameRow,
    Header,
    Journal,
    JournalWriter,
    ObjectRow,
    journal_of,
    object_rows,
)
from motes.output.painters import ScenePainter
from motes.output.track_rows import check_not_deleted, check_writable
from motes.video.writer import VideoWriter

if TYPE_CHECKING:
    from motes.video.sources import Source

Form = Literal["mot", "csv", "jsonl"]
FORMS: dict[str, Form] = {".txt": "mot", ".csv": "csv", ".jsonl": "jsonl"}
"""Forms of rows, by the ending of the file; other endings are those of `DOCUMENTS`."""
LABEL = "object"
"""Default class of the objects."""
COLUMNS = (
    "frame", "time", "identity", "x", "y", "width", "height", "confidence", "status", "occluded_by",
    "class",
)  # fmt: skip
MOT_CLASSES = {
    "pedestrian": 1, "person": 1, "car": 3, "bicycle": 4, "motorbike": 5, "motorcycle": 5,
}  # fmt: skip
"""Numbers of classes in the MOTChallenge (Milan et al., MOT16, 2016, table 3)."""


@dataclass(frozen=True, slots=True)
class FrameResult:
    """The result of a frame."""

    frame: Frame
    tracks: Sequence[SceneTrack]
    events: Sequence[Event]


class Output(Protocol):
    """Takes results of frames; is closed as a context manager."""

    def write(self, moment: FrameResult) -> None:
        """Add a frame."""
        ...

    @property
    def result(self) -> str | None:
        """The name of what was written, for the summary; None for nothing."""
        ...

    def __enter__(self) -> Self: ...

    def __exit__(self, *exception: object) -> None: ...


class Lines:
    """Lines in a file or on standard output, without a buffer.

    The file is made with the first line, or at the end of a run that had none.
    """

    def __init__(self, name: str, overwrite: bool) -> None:
        self.name = name
        self._overwrite = overwrite
        self._file: BinaryIO | None = None
        if name != "-":
            check_writable(name, overwrite)

    def put(self, lines: Sequence[str]) -> None:
        """Write lines; raise a FormatError if that fails."""
        file = self._file or self._open()
        if self.name != "-":
            check_not_deleted(file, self.name)
        try:
            write_all(file, "".join(line + "\n" for line in lines).encode())
        except BrokenPipeError:  # the reader has closed the pipe
            raise
        except OSError as error:
            raise self._failure(error) from error

    @property
    def result(self) -> str | None:
        """The file."""
        return self.name if self._file is not None and self.name != "-" else None

    def _failure(self, error: OSError) -> FormatError:
        return FormatError(
            f"{self.name} cannot be written: {error.strerror}; make room, or choose another place. "
            f"Existing lines are kept."
        )

    def _open(self) -> BinaryIO:
        screen = self.name == "-"
        try:
            if screen:
                file: BinaryIO = os.fdopen(sys.stdout.fileno(), "wb", buffering=0, closefd=False)
            else:
                file = open_rows(self.name, self._overwrite)
        except OSError as error:
            raise self._failure(error) from error
        self._file = file
        return file

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *exception: object) -> None:
        if self._file is None and exception[0] is None:
            self._open()
        if self._file is not None:
            self._file.close()


def objects_output(
    name: str, film: Source, *, overwrite: bool, form: Form | None = None, label: str | None = None
) -> Output:
    """Return the output of all objects of each frame, in the form of the name's ending.

    Raises
    ------
    ConfigError
        If the ending is unknown and no form of rows is given.
    FormatError
        If a file exists and must not be overwritten, or cannot be made.
    """
    if form is None and is_document(name):
        return Annotations(name, film, label or LABEL, overwrite)
    return Rows(name, form or form_of(name), overwrite)


def form_of(name: str) -> Form:
    """Return the form of rows of a name's ending; raise a ConfigError for another ending."""
    ending = ".csv" if name == "-" else Path(name).suffix.lower()
    if ending not in FORMS:
        raise ConfigError(f"{name} ends in none of {', '.join([*FORMS, *DOCUMENTS])}; rename it.")
    return FORMS[ending]


class Rows(Lines):
    """A row for each object in each frame.

    - CSV and JSON Lines have rows of all objects, with `COLUMNS`.
    - The form of the MOTChallenge has rows of visible objects: frame, identity, x, y, width,
      height, confidence, class, visibility 1, -1. Frames and pixels count from 1. The class is 1
      for an object without one, and -1 for one that is none of `MOT_CLASSES`. An occluded object
      has no row, as the form cannot mark a predicted box, and scores would count it.
    """

    def __init__(self, name: str, form: Form, overwrite: bool) -> None:
        super().__init__(name, overwrite)
        self._form = form
        self._begun = False

    def write(self, moment: FrameResult) -> None:
        """Add a frame's rows."""
        self.add(FrameRow(moment.frame.index, moment.frame.time, object_rows(moment.tracks)))

    def add(self, picture: FrameRow) -> None:
        """Add a frame's rows."""
        if self._form == "csv" and not self._begun:
            self.put([",".join(COLUMNS)])
        self._begun = True
        if self._form == "mot":
            seen = [each for each in picture.objects if each.status is Status.TRACKING]
            self.put([_mot(picture, each) for each in seen])
        else:
            self.put([_row(picture, each, self._form) for each in picture.objects])


def _mot(picture: FrameRow, each: ObjectRow) -> str:
    x, y, width, height = each.box
    box = f"{x + 1:.2f},{y + 1:.2f},{width:.2f},{height:.2f}"
    label = 1 if each.label is None else MOT_CLASSES.get(each.label.lower(), -1)
    return f"{picture.frame + 1},{each.identity},{box},{each.confidence:.4f},{label},1,-1"


def csv_line(values: Sequence[object]) -> str:
    """Return values as a line of CSV: None is empty, and a text that needs quotes has them."""
    return ",".join(map(_csv_field, values))


def _csv_field(value: object) -> str:
    text = "" if value is None else str(value)
    if not any(mark in text for mark in ',"\r\n'):
        return text
    return '"' + text.replace('"', '""') + '"'


def _row(picture: FrameRow, each: ObjectRow, form: Form) -> str:
    values = [
        picture.frame, round(picture.time, 6), each.identity,
        *(round(value, 3) for value in each.box), round(each.confidence, 5), each.status,
        each.occluded_by, each.label,
    ]  # fmt: skip
    if form == "csv":
        return csv_line(values)
    return msgspec.json.encode(dict(zip(COLUMNS, values, strict=True))).decode()


class Annotations:
    """A document for annotation tools, made at the end, also of an interrupted run.

    Until then a journal beside it holds the rows; it stays if the document cannot be made.
    """

    def __init__(self, name: str, film: Source, label: str, overwrite: bool) -> None:
        check_writable(name, overwrite)
        self.path, self.rows = Path(name), journal_of(name)
        if os.path.lexists(self.rows):
            raise FormatError(
                f"{self.rows} exists: rows of a run that was killed, or still goes on. Make its "
                f"document with {self._remedy}, then remove it; or choose another name."
            )
        self._film, self._label = film, label
        self._journal: JournalWriter | None = None
        self._failed = self._done = False

    def write(self, moment: FrameResult) -> None:
        """Add a frame's objects to the journal."""
        frame = moment.frame
        file = self._film.file_of(frame.index)
        objects = object_rows(moment.tracks)
        try:
            if self._journal is None:
                head = Header(_text(self._film.name), frame.width, frame.height, self._label)
                self._journal = JournalWriter(self.rows, head)
            name = None if file is None else _text(file)
            self._journal.add(FrameRow(frame.index, frame.time, objects, name))
        except OSError as error:
            self._failed = True
            raise self._failure(error) from error

    @property
    def result(self) -> str | None:
        """The document, or the journal in its place."""
        if self._done:
            return str(self.path)
        return None if self._journal is None else f"{self.rows}, but not {self.path}"

    @property
    def _remedy(self) -> str:
        return f"motes convert {shlex.quote(str(self.rows))} -o {shlex.quote(str(self.path))}"

    def _failure(self, error: OSError) -> FormatError:
        advice = "make room, or choose another place."
        if self._journal is not None:
            advice = f"its rows are kept in {self.rows}. Make room, then: {self._remedy}"
        return FormatError(f"{self.path} cannot be written: {error.strerror}; {advice}")

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *exception: object) -> None:
        if self._journal is None:
            return
        self._journal.close()
        if self._failed:
            return
        try:
            write_document(self.path, Journal(self.rows))
        except OSError as error:
            raise self._failure(error) from error
        self._done = True
        self.rows.unlink(missing_ok=True)


def _text(name: str) -> str:
    """Return the name of a file with escapes for bytes that are no text."""
    return name.encode(errors="backslashreplace").decode()


class Events(Lines):
    """A line of JSON for each event."""

    def write(self, moment: FrameResult) -> None:
        """Add a frame's events."""
        self.put([event.json() for event in moment.events])


def film_state(writer: VideoWriter) -> str | None:
    """Return the name of a written video, for the summary; None for nothing."""
    if writer.result is None:
        return None
    return f"{writer.result}" + " (unfinished)" * (writer.result != writer.path)


class Overlay:
    """An annotated video, with the time, and the crossings, entries and exits so far."""

    def __init__(
        self, path: Path, source: Source, stride: int, places: Regions, *, overwrite: bool
    ) -> None:
        check_writable(path, overwrite)
        self._writer = VideoWriter(path, (source.fps or 1 / FRAME_INTERVAL) / stride, overwrite)
        self._painter = ScenePainter(places)
        self._start: float | None = None

    def write(self, moment: FrameResult) -> None:
        """Add a picture."""
        pixels = self._painter.painted(moment.frame, moment.tracks, moment.events)()
        if self._start is None:
            self._start = moment.frame.time
        self._writer.write(pixels, moment.frame.time - self._start)

    @property
    def result(self) -> str | None:
        """The video, or the unfinished file that an error left."""
        return film_state(self._writer)

    def __enter__(self) -> Self:
        self._writer.__enter__()
        return self

    def __exit__(self, *exception: object) -> None:
        kind, error, trace = exception
        # A video that Ctrl-C ended is complete up to its last frame.
        self._writer.__exit__(kind, error, trace)  # type: ignore[arg-type]
