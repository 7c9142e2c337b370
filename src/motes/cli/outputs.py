"""What a run is asked for: its film, and its outputs: rows, their history, documents, events."""

from __future__ import annotations

import dataclasses
import math
import os
import shlex
from bisect import bisect_left
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Generic, TypeVar

from msgspec.structs import replace

from motes.cli.annotated_video import AnnotatedVideo, Painter
from motes.cli.frame_loop import Moment, Sink
from motes.cli.input_checks import STREAMED, RowsGoal, check_place, usual_format
from motes.cli.option_groups import FrameOptions, OutputOptions
from motes.cli.streams import log
from motes.core import interrupts
from motes.core.config import Config
from motes.core.errors import FormatError, InputError, SourceError, counted
from motes.core.files import check_writable, is_special, leftovers
from motes.core.track import GROUND
from motes.correction.history import History
from motes.formats.mot import line_of
from motes.formats.recording import LABEL, Recording
from motes.formats.registry import (
    FORMATS,
    Written,
    check_images,
    frames_told,
    write as write_format,
)
from motes.formats.rows import recording_of_journal
from motes.formats.visibility import visible
from motes.mot.analytics.event import Event
from motes.mot.analytics.real_units import RealUnits
from motes.mot.analytics.regions import Regions
from motes.rows.schema import Form, FrameRow, Header, journal_of, text_name
from motes.rows.writer import JournalWriter, Lines, TrackWriter
from motes.video.film import Film
from motes.video.sources import Source, is_recorded


class RowsOutput(Sink):
    """Rows of motes in a file or on standard output."""

    def __init__(self, writer: TrackWriter, *, resume: bool) -> None:
        self._writer, self._resume, self._complete = writer, resume, False

    def write(self, moment: Moment) -> None:
        """Add a frame's rows."""
        self._writer.add(moment.rows)

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


class HistoryOutput(Sink):
    """The history of a run, beside its rows, from before the first one on.

    Raises a FormatError if the file exists and must not be overwritten, or cannot be made. To
    resume, the rows that are there are compared. As they may be of another run, their history stays
    until there is a new row.
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
        """Note where the run ended, and how many lines the rows have, unless it failed.

        Where the film cannot be read any further, it has ended.
        """
        begun = self._history.last is not None
        ended = kind is None or issubclass(kind, KeyboardInterrupt | SourceError)
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
        objects = tuple(each for each in row.objects if each.placed)
        searched = tuple(each.identity for each in row.objects if each.searched)
        try:
            if self._journal is None:
                head = Header(
                    text_name(film.name), film.width, film.height, self._options.label or LABEL
                )
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
            why = made.missed_told
            without = f" without {counted(made.missed, 'frame')} in which a target is {why}"
            guesses = guesses_told(made, self.hint)
            return f"{self.path}{without * (made.missed > 0)}{guesses}"
        return None if self._journal is None else f"{self.rows}, but not {self.path}"

    @property
    def _remedy(self) -> str:
        words = ["motes", "convert", str(self.rows), "-o", str(self.path)]
        if self._form != usual_format(str(self.path)):
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


def guesses_told(written: Written, hint: str = DocumentOutput.hint) -> str:
    """Return what has become of guesses and unknown frames, for a command's last line; or ""."""
    told, frames = written.guesses_told, counted(written.unknown, "frame")
    absent = f"; called absent: {frames} without a row" * (written.unknown > 0)
    return f"; {told}{hint}{absent}" if told else absent


def say_how_to_train(path: Path, form: str, recorded: Recording) -> None:
    """Print how the images come to labels of YOLO, or where another tool has others in a frame."""
    if told := frames_told(form, recorded):
        log(f"{path}: {told}")
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


class EventsOutput(Lines):
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
            if self._waiting:  # else a run that failed at once would leave an empty file
                with suppress(BrokenPipeError):  # whoever reads standard output has left
                    self.put([event.json() for event in self._waiting])
        finally:
            super().__exit__(*exception)  # type: ignore[arg-type]


Configuration = TypeVar("Configuration", bound=Config)


@dataclass(frozen=True, kw_only=True)
class Request(Generic[Configuration]):
    """A film, its outputs, and how its results are made."""

    source: str
    frames: FrameOptions
    """The film and its frames, as they are given."""
    goal: RowsGoal | None
    outputs: OutputOptions
    """Where the rows go, None without rows; and all options of outputs."""
    config: Configuration
    seed: int
    preset: str
    """The tracker or the scene, and the name of its preset."""
    units: RealUnits | None = None
    places: Regions | None = None
    """How pixels become metres, and lines and zones, as in `History`."""
    resume: bool = False
    """Whether existing rows are the beginning of these, and pictures are made again."""

    @property
    def overwrite(self) -> bool:
        """Whether existing files may be replaced."""
        return self.outputs.overwrite or self.resume

    @property
    def rows_file(self) -> Path | None:
        """The file of rows beside which a history is written; none of streams and documents."""
        goal = self.goal
        if goal is None or goal.form not in STREAMED or goal.name == "-" or is_special(goal.name):
            return None
        return Path(goal.name)

    def pictures(self, film: Source | Film, painter: Painter) -> list[Sink]:
        """Return the output --overlay."""
        if (path := self.outputs.overlay) is None:
            return []
        return [AnnotatedVideo(path, film, painter, self.frames.stride, overwrite=self.overwrite)]

    def rows(self, film: Source | Film, hindsight: Sequence[str] = ()) -> list[Sink]:
        """Return what writes the rows, also in metres; none if they are not asked for.

        Raises a FormatError if a file exists and must not be overwritten, or cannot be made.
        """
        if self.goal is None:
            return []
        (name, form), options = self.goal, self.outputs
        if form == "mot":
            return [MotOutput(name, options.overwrite)]
        if form not in STREAMED:
            return [DocumentOutput(name, form, film, options)]
        kind: Form = "csv" if form == "csv" else "jsonl"
        further = hindsight if self.units is None else (*hindsight, *GROUND)
        writer = TrackWriter(
            name, kind, overwrite=options.overwrite, resume=self.resume, further=further
        )
        return [RowsOutput(writer, resume=self.resume)]

    def rows_and_history(self, film: Source) -> list[Sink]:
        """Return what writes the rows, after what writes their history."""
        outputs, rows = self.rows(film), self.rows_file
        if rows is None:
            return outputs
        history = History.of_run(
            film, self.config, self.seed, self.preset, units=self.units, places=self.places,
            start=self.frames.start, end=self.frames.end, stride=self.frames.stride,
        )  # fmt: skip
        if self.resume:  # what a killed run has left of it
            for left in leftovers(History.path(rows)):
                left.unlink(missing_ok=True)
        overwrite, resume = self.outputs.overwrite, self.resume
        return [HistoryOutput(rows, history, overwrite=overwrite, resume=resume), *outputs]
