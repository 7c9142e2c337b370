"""The outputs of several objects: rows, documents, events, an annotated video."""

from __future__ import annotations

import os
import shlex
import sys
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, BinaryIO, Self

from msgspec.structs import replace

from motes.cli.annotated_video import AnnotatedVideo
from motes.cli.options import OutputOptions
from motes.core.errors import ConfigError, FormatError
from motes.core.files import open_rows, write_all
from motes.core.frame import Frame
from motes.formats.mot import result_line
from motes.formats.registry import FORMATS, check_folder, format_for
from motes.formats.registry import write as write_format
from motes.formats.rows import OBJECT_COLUMNS, object_line, object_values
from motes.formats.visibility import visible
from motes.mot.analytics.events import Event
from motes.mot.analytics.regions import Regions
from motes.mot.tracked_object import SceneTrack
from motes.output.journal import (
    FrameRow,
    Header,
    Journal,
    JournalWriter,
    journal_of,
    object_rows,
)
from motes.output.painters import ScenePainter
from motes.output.track_rows import Form as RowForm
from motes.output.track_rows import check_not_deleted, check_writable

if TYPE_CHECKING:
    from motes.video.film import Film
    from motes.video.sources import Source

STREAMED = ("csv", "jsonl", "mot")
"""Formats that grow row by row; all others are made at the end."""
LABEL = "object"
"""Default class of the objects."""


@dataclass(frozen=True, slots=True)
class FrameResult:
    """The result of a frame."""

    frame: Frame
    tracks: Sequence[SceneTrack]
    events: Sequence[Event]


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


def objects_output(name: str, film: Source | Film, options: OutputOptions) -> ObjectsOutput:
    """Return the output of all objects of each frame.

    Parameters
    ----------
    name
        The file, or -.
    film
        The film.
    options
        The format, the class of the objects, and whether a file may be overwritten.

    Raises
    ------
    ConfigError
        If the ending is unknown and no format is given.
    FormatError
        If a file exists and must not be overwritten, or cannot be made.
    """
    form = format_of(name, options.format)
    if form in STREAMED:
        return ObjectRows(name, form, options.overwrite)
    label = options.label or LABEL
    return DocumentOutput(name, form, film, label, options.overwrite, options.keyframe_error)


def format_of(name: str, form: str | None = None) -> str:
    """Return the name of an output's format: `form` if given, else that of the name's ending.

    Raises
    ------
    ConfigError
        If the ending or the format is unknown, or the format cannot be written.
    """
    if form is None:
        return "csv" if name == "-" else format_for(name)
    if FORMATS.resolve(form).write is None:
        raise ConfigError(f"Files of the format {form} cannot be written; give another one.")
    if name == "-" and form not in STREAMED:
        raise ConfigError(f"{form} is made at the end of a run; give it a file, not -.")
    return form


def row_form(form: str | None) -> RowForm | None:
    """Return the form of a format that has the rows of one target as it is written; or None."""
    forms: dict[str | None, RowForm] = {"csv": "csv", "jsonl": "jsonl"}
    return forms.get(form)


def is_document(name: str, form: str | None = None) -> bool:
    """Return whether an output is made at the end of a run."""
    forms = [form] if form is not None else _usual_format(name)
    return any(each not in STREAMED for each in forms)


def check_several(name: str, form: str | None) -> None:
    """Raise a ConfigError if an output's format holds one object, but there may be several."""
    form = format_of(name, form)
    if FORMATS.resolve(form).single:
        raise ConfigError(f"{form} holds one object, and there may be several; choose another.")


class ObjectRows(Lines):
    """A row for each object in each frame, in one of the formats `STREAMED`."""

    def __init__(self, name: str, form: str, overwrite: bool) -> None:
        super().__init__(name, overwrite)
        self._form = form
        self._begun = False

    def write(self, moment: FrameResult) -> None:
        """Add a frame's rows."""
        self.add(FrameRow(moment.frame.index, moment.frame.time, object_rows(moment.tracks)))

    def add(self, picture: FrameRow) -> None:
        """Add a frame's rows."""
        if self._form == "csv" and not self._begun:
            self.put([",".join(OBJECT_COLUMNS)])
        self._begun = True
        if self._form == "mot":
            self.put([result_line(picture.frame, each) for each in visible(picture)])
        else:
            form: RowForm = "csv" if self._form == "csv" else "jsonl"
            self.put(
                [
                    object_line(form, OBJECT_COLUMNS, object_values(picture, each))
                    for each in picture.objects
                ]
            )


class DocumentOutput:
    """A file of a format that is made at the end, also of an interrupted run.

    Until then a journal beside it holds the rows; it stays if the document cannot be made.
    """

    def __init__(
        self,
        name: str,
        form: str,
        film: Source | Film,
        label: str,
        overwrite: bool,
        keyframe_error: float | None,
    ) -> None:
        check_place(name, form, overwrite)
        self.path, self.rows, self._form = Path(name), journal_of(name), form
        self._keyframe_error = keyframe_error
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
        self.add(FrameRow(moment.frame.index, moment.frame.time, object_rows(moment.tracks)))

    def add(self, picture: FrameRow) -> None:
        """Add the rows of a frame to the journal, with the name of the frame's image."""
        film, file = self._film, self._film.file_of(picture.frame)
        try:
            if self._journal is None:
                head = Header(_text(film.name), film.width, film.height, self._label)
                self._journal = JournalWriter(self.rows, head)
            self._journal.add(replace(picture, file=None if file is None else _text(file)))
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
        words = ["motes", "convert", str(self.rows), "-o", str(self.path)]
        if self._form not in _usual_format(str(self.path)):
            words += ["--to", self._form]
        return shlex.join(words)

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
            write_format(self.path, self._form, Journal(self.rows), self._keyframe_error)
        except OSError as error:
            raise self._failure(error) from error
        self._done = True
        self.rows.unlink(missing_ok=True)


def check_place(name: str, form: str, overwrite: bool) -> None:
    """Check that a file, or a folder, of a format can be made.

    Raises
    ------
    FormatError
        If it exists and must not be overwritten, or the folder above is missing or protected.
    """
    if not FORMATS.resolve(form).folder:
        check_writable(name, overwrite)
    elif os.path.isdir(name) and os.listdir(name) and not overwrite:
        raise FormatError(f"{name} has files; choose another name, or overwrite it (--overwrite).")
    elif not os.path.isdir(name):
        check_writable(name)
    else:
        check_folder(Path(name))


def _usual_format(name: str) -> list[str]:
    """Return the format that a name's ending chooses, in a list; none if there is no such one."""
    try:
        return [format_for(name)]
    except ConfigError:
        return []


def _text(name: str) -> str:
    """Return the name of a file with escapes for bytes that are no text."""
    return name.encode(errors="backslashreplace").decode()


ObjectsOutput = ObjectRows | DocumentOutput
"""An output of the objects of each frame; it also takes rows that are made already."""


class Events(Lines):
    """A line of JSON for each event."""

    def write(self, moment: FrameResult) -> None:
        """Add a frame's events."""
        self.put([event.json() for event in moment.events])


class SceneOverlay(AnnotatedVideo):
    """An annotated video, with the time, and the crossings, entries and exits so far."""

    def __init__(
        self, path: Path, source: Source, stride: int, places: Regions, *, overwrite: bool
    ) -> None:
        super().__init__(path, source, stride, overwrite=overwrite)
        self._painter = ScenePainter(places)

    def write(self, moment: FrameResult) -> None:
        """Add a picture."""
        pixels = self._painter.painted(moment.frame, moment.tracks, moment.events)()
        self.add(pixels, moment.frame.time)
