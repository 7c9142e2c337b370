"""The outputs of a run: rows, what is remembered of them, documents, events."""

from __future__ import annotations

import dataclasses
import math
import os
import shlex
from bisect import bisect_left
from contextlib import suppress
from pathlib import Path

from msgspec.structs import replace

from motes.cli.frame_loop import Moment, Sink
from motes.cli.option_groups import OutputOptions
from motes.cli.streams import log
from motes.core import interrupts
from motes.core.errors import ConfigError, FormatError, InputError, SourceError, counted
from motes.core.files import check_writable
from motes.correction.history import History
from motes.formats.mot import line_of
from motes.formats.recording import LABEL, Recording
from motes.formats.registry import FORMATS, Written, check_folder, check_images, format_for
from motes.formats.registry import write as write_format
from motes.formats.rows import recording_of_journal
from motes.formats.visibility import visible
from motes.mot.analytics.event import Event
from motes.rows.schema import FrameRow, Header, journal_of, text_name
from motes.rows.writer import JournalWriter, Lines, TrackWriter
from motes.video.film import Film
from motes.video.sources import Source, is_recorded

STREAMED = ("csv", "jsonl", "mot")
"""Formats that grow row by row; all others are made at the end."""


def format_of(name: str, form: str | None) -> str:
    """Return the name of an output's format: `form` if given, else that of the name's ending.

    Raises a ConfigError if the ending or the format is unknown, or the format cannot be written.
    """
    if form is None:
        return "csv" if name == "-" else format_for(name)
    if FORMATS.resolve(form).write is None:
        raise ConfigError(f"Files of the format {form} cannot be written; give another one.")
    if name == "-" and form not in STREAMED:
        raise ConfigError(f"{form} is made at the end of a run; give it a file, not -.")
    return form


def is_document(name: str, form: str | None) -> bool:
    """Return whether an output is made at the end of a run."""
    forms = [form] if form is not None else _usual_format(name)
    return any(each not in STREAMED for each in forms)


def check_several(name: str, form: str | None) -> None:
    """Raise a ConfigError if an output's format holds one object, but there may be several."""
    form = format_of(name, form)
    if FORMATS.resolve(form).single:
        raise ConfigError(f"{form} holds one object, and there may be several; choose another.")


def labeled(row: FrameRow, label: str | None) -> FrameRow:
    """Return a frame's rows in which objects without a class have this one, if it is given."""
    if label is None:
        return row
    return replace(
        row, objects=tuple(replace(each, label=each.label or label) for each in row.objects)
    )


class RowsOutput(Sink):
    """Rows of motes in a file or on standard output; objects without a class get `label`."""

    def __init__(self, writer: TrackWriter, label: str | None, *, resume: bool) -> None:
        self._writer, self._label = writer, label
        self._resume, self._complete = resume, False

    def write(self, moment: Moment) -> None:
        """Add a frame's rows."""
        self._writer.add(labeled(moment.rows, self._label))

    @property
    def result(self) -> str | None:
        """The file, and the number of rows that it had before."""
        name, rows, resumed = self._writer.name, self._writer.rows, self._writer.resumed
        if not self._resume or name == "-":
            return self._writer.result
        if rows == resumed:
            return f"{name} (it had all {rows} rows already)" if self._complete else None
        return f"{name} (rows from {resumed + 1} on)"

    def __exit__(self, kind: type[BaseException] | None, *rest: object) -> None:
        if self._resume and interrupts.came():  # then fewer rows than there were are no other run's
            kind = kind or KeyboardInterrupt
        self._writer.__exit__(kind, *rest)
        self._complete = kind is None


class Remembered(Sink):
    """What is to be remembered of a run, beside its rows, from before the first one on.

    Raises a FormatError if the file exists and must not be overwritten, or cannot be made. To
    resume, the rows that are there are compared. As they may be of another run, what is remembered
    of them stays until there is a new one.
    """

    def __init__(self, rows: Path, history: History, *, overwrite: bool, resume: bool) -> None:
        self._rows, self._history, path = rows, history, History.path(rows)
        check_writable(rows, overwrite=True)  # a missing folder is that of the rows
        check_writable(path, overwrite or resume)
        self._compared: float = -1
        """The last frame whose rows are there."""
        if resume and path.exists():
            with suppress(InputError):  # what cannot be read is replaced
                last = History.load(path).last
                self._compared = math.inf if last is None else last

    def write(self, moment: Moment) -> None:
        """Write the file before the first new row; remember which frame is the last."""
        if moment.frame.index > self._compared:
            self._history.save(self._rows)
            self._compared = math.inf
        self._history = replace(self._history, last=moment.frame.index)

    def __exit__(self, kind: type[BaseException] | None, *_: object) -> None:
        """Note where the run ended, and how many lines the rows have, unless it failed."""
        begun = self._history.last is not None
        ended = kind is None or issubclass(kind, KeyboardInterrupt)
        if begun and ended and self._rows.is_file():  # no pipe, and not moved meanwhile
            self._history.save(self._rows, whole=True)


class MotOutput(Lines):
    """Results of the MOTChallenge: a line for each visible object in each frame."""

    def write(self, moment: Moment) -> None:
        """Add a frame's lines."""
        self.put([line_of("results", each) for each in visible(moment.rows)])


class DocumentOutput(Sink):
    """A file of a format that is made at the end, also of an interrupted run.

    Until then a journal beside it holds the rows; it stays if the document cannot be made.
    """

    hint = "; see --with-guesses"
    """What is said after a number of guesses: the option by which they are written."""

    def __init__(self, name: str, form: str, film: Source | Film, options: OutputOptions) -> None:
        check_place(name, form, options.overwrite)
        if FORMATS.resolve(form).folder:
            check_images(map(text_name, film.files))
        self.path, self.rows, self._form = Path(name), journal_of(name), form
        self._film, self._options = film, options
        if os.path.lexists(self.rows):
            raise FormatError(
                f"{self.rows} exists: rows of a run that was killed, or still goes on. Make its "
                f"document with {self._remedy}, then remove it; or choose another name."
            )
        self._journal: JournalWriter | None = None
        self._failed = self._done = False
        self._written = Written(0, 0)

    def write(self, moment: Moment) -> None:
        """Add a frame's objects to the journal."""
        self.add(moment.rows)

    def add(self, row: FrameRow) -> None:
        """Add the objects of a frame that have a place, and the name of the frame's image."""
        film, files = self._film, self._film.files
        label = self._options.label
        row = labeled(row, label)
        objects = tuple(each for each in row.objects if each.placed)
        searched = tuple(each.identity for each in row.objects if each.searched)
        try:
            if self._journal is None:
                head = Header(text_name(film.name), film.width, film.height, label or LABEL)
                self._journal = JournalWriter(self.rows, head)
            name = text_name(files[row.frame]) if files else None
            self._journal.add(replace(row, objects=objects, file=name, searched=searched))
        except FormatError as error:
            self._failed = True
            if isinstance(error.__cause__, OSError):
                raise self._failure(error.__cause__) from error
            raise

    @property
    def result(self) -> str | None:
        """The document, or the journal in its place."""
        if self._done:
            made = self._written
            without = (
                f" without {counted(made.missed, 'frame')} in which a target is {unseen(made)}"
            )
            guesses = guesses_told(self._form, made, self.hint)
            return f"{self.path}{without * (made.missed > 0)}{guesses}"
        return None if self._journal is None else f"{self.rows}, but not {self.path}"

    @property
    def _remedy(self) -> str:
        words = ["motes", "convert", str(self.rows), "-o", str(self.path)]
        if self._form not in _usual_format(str(self.path)):
            words += ["--to", self._form]
        if self._form == "cvat" and _kept(self._film):
            words += ["--video", self._film.name]  # which tells where it ends
            rate = self._film.even_rate
            words += [] if rate is None else ["--fps", f"{rate:g}"]
        words += ["--with-guesses"] * self._options.with_guesses
        return shlex.join(words)

    def _failure(self, error: OSError) -> FormatError:
        advice = "make room, or choose another place."
        if self._journal is not None:
            advice = f"its rows are kept in {self.rows}. Make room, then: {self._remedy}"
        return FormatError(f"{self.path} cannot be written: {error.strerror}; {advice}")

    def __exit__(self, *exception: object) -> None:
        if self._journal is None:
            return
        self._journal.close()
        if self._failed:
            return
        try:
            kept = recording_of_journal(self.rows)
            if self._form == "cvat":  # which goes on after the last keyframe
                kept = dataclasses.replace(kept, length=_length(self._film))
            error, guesses = self._options.keyframe_error, self._options.with_guesses
            self._written = write_format(self.path, self._form, kept, error, guesses=guesses)
        except OSError as error:
            raise self._failure(error) from error
        self._done = True
        self.rows.unlink(missing_ok=True)
        say_how_to_train(self.path, self._form, kept)


def _kept(film: Source | Film) -> bool:
    """Return whether a film can be read again: it is no camera, and is still there."""
    return is_recorded(film.name) and os.path.exists(film.name)


def _length(film: Source | Film) -> int:
    """Return the number of frames of a whole film, also if a run has ended before; 0 if unknown."""
    if not _kept(film):
        return 0
    with suppress(SourceError):  # it may be damaged by now
        return len(film.files) or len(Film.quickly(film.name, check=lambda: None).times)
    return 0


def unseen(written: Written) -> str:
    """Return what a target is in the frames that are left out."""
    return "lost or searched for" + ", or guessed" * (written.guesses > 0)


def guesses_told(form: str, written: Written, hint: str = DocumentOutput.hint) -> str:
    """Return what has become of guesses, for the line that ends a command; "" without any."""
    told = written.guesses_told(form)
    return f"; {told}{hint}" if told else ""


def say_how_to_train(path: Path, form: str, recorded: Recording) -> None:
    """Print how the images come to labels of YOLO; nothing for other formats."""
    if form != "yolo":
        return
    film, images = recorded.head.source, str(path / "images")
    if os.path.isdir(film):
        way = shlex.join(["cp", "-r", film, images])
    elif os.path.isfile(film) and not any(row.file for row in recorded):
        make = ["ffmpeg", "-i", film, "-fps_mode", "passthrough", "-start_number", "0"]
        make.append(f"{images}/frame_%06d.png")
        way = f"{shlex.join(['mkdir', images])} && {shlex.join(make)}"
    else:
        way = f"those that {path / 'train.txt'} lists, into {images}"
    log(f"to train with {path}, put its images beside its labels: {way}")


def check_place(name: str, form: str, overwrite: bool) -> None:
    """Check that a file, or a folder, of a format can be made.

    Raises a FormatError if it exists and must not be overwritten, or the folder above is missing or
    protected.
    """
    known = FORMATS.resolve(form)
    if not known.folder:
        check_writable(name, overwrite)
    elif os.path.isdir(name) and os.listdir(name) and not overwrite:
        raise FormatError(f"{name} has files; choose another name, or overwrite it (--overwrite).")
    elif not os.path.isdir(name):
        check_writable(name)
    else:
        check_folder(Path(name), known)


def _usual_format(name: str) -> list[str]:
    """Return the format that a name's ending chooses, in a list; none if there is no such one."""
    try:
        return [format_for(name)]
    except ConfigError:
        return []


class Events(Lines):
    """A line of JSON for each event, in the order of frames.

    An event waits until no earlier one may come any more.
    """

    def __init__(self, name: str, overwrite: bool) -> None:
        super().__init__(name, overwrite)
        self._waiting: list[Event] = []

    def write(self, moment: Moment) -> None:
        """Add a frame's events."""
        waiting = sorted([*self._waiting, *moment.events], key=lambda event: event.frame)
        done = len(waiting)
        if moment.undecided is not None:
            done = bisect_left(waiting, moment.undecided, key=lambda event: event.frame)
        self._waiting = waiting[done:]
        self.put([event.json() for event in waiting[:done]])

    def __exit__(self, *exception: object) -> None:
        """Write the events that wait, and close the file."""
        try:
            with suppress(BrokenPipeError):  # whoever reads standard output has left
                self.put([event.json() for event in self._waiting])
        finally:
            super().__exit__(*exception)  # type: ignore[arg-type]
