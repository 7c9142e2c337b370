"""The outputs of `motes track`: rows, an annotated video, figures."""

from __future__ import annotations

import os
from collections.abc import Sequence
from math import isfinite
from pathlib import Path
from typing import TYPE_CHECKING, Self

from motes.cli.annotated_video import AnnotatedVideo
from motes.cli.track_loop import Companion, Step
from motes.cli.watch_outputs import ObjectsOutput
from motes.core.errors import FormatError
from motes.core.track import Status
from motes.output.journal import FrameRow, ObjectRow
from motes.output.painters import TrackPainter
from motes.output.track_rows import COLUMNS, Form, TrackWriter
from motes.sot.presets import TrackerConfig

if TYPE_CHECKING:
    from motes.video.film import Film
    from motes.video.sources import Source


class TrackRows:
    """Rows in a file or on standard output; checks on construction that they can be written."""

    def __init__(
        self,
        path: str,
        form: Form | None,
        *,
        overwrite: bool,
        resume: bool = False,
        columns: Sequence[str] = COLUMNS,
    ) -> None:
        self._name, self._resume, self._complete = path, resume, False
        self._writer = TrackWriter(path, form, overwrite=overwrite, resume=resume, columns=columns)

    def write(self, step: Step) -> None:
        """Add a row."""
        self._writer.write(step.frame.index, step.frame.time, step.track, step.ground)

    @property
    def result(self) -> str | None:
        """The file, and the number of rows that it had before."""
        rows, resumed = self._writer.rows, self._writer.resumed
        if self._name == "-":
            return None
        if rows == resumed:
            return f"{self._name} (it had all {rows} rows already)" if self._complete else None
        return f"{self._name} (rows from {resumed + 1} on)" if self._resume else self._name

    def __enter__(self) -> Self:
        return self

    def __exit__(self, kind: type[BaseException] | None, *rest: object) -> None:
        self._writer.__exit__(kind, *rest)
        self._complete = kind is None


class AsObjects:
    """The target as one of several objects, in a format that only they have."""

    def __init__(self, inner: ObjectsOutput) -> None:
        self._inner = inner

    def write(self, step: Step) -> None:
        """Add a frame."""
        there = step.track is not None and step.track.status is not Status.ABSENT
        objects = (ObjectRow.of_target(step.track, step.ground),) if step.track and there else ()
        self._inner.add(FrameRow(step.frame.index, step.frame.time, objects))

    @property
    def result(self) -> str | None:
        """The file, or the one written in its place."""
        return self._inner.result

    def __enter__(self) -> Self:
        self._inner.__enter__()
        return self

    def __exit__(self, *exception: object) -> None:
        self._inner.__exit__(*exception)


class TrackOverlay(AnnotatedVideo):
    """An annotated video; with a unit of length, it shows the speed."""

    def __init__(
        self,
        path: Path,
        source: Source | Film,
        stride: int,
        *,
        overwrite: bool,
        unit: str | None = None,
    ) -> None:
        super().__init__(path, source, stride, overwrite=overwrite)
        self._painter, self._unit = TrackPainter(), unit

    def write(self, step: Step) -> None:
        """Add a picture."""
        note = ""
        if self._unit is not None and step.place is not None and isfinite(step.place.speed):
            note = f"{step.place.speed:.2f} {self._unit}/s"
        self.add(self._painter.painted(step.frame, step.info, note)(), step.frame.time)


class Figures:
    """The figures of the papers, drawn at the end, also after an interruption."""

    def __init__(self, folder: Path, config: TrackerConfig, *, overwrite: bool) -> None:
        from motes.output.figures import Recorder

        if folder.exists() and not folder.is_dir():
            raise FormatError(f"{folder} is not a folder; choose another name.")
        place = next(each for each in (folder, *folder.absolute().parents) if each.exists())
        if not os.access(place, os.W_OK):
            raise FormatError(f"{folder} cannot be written: no permission; choose another folder.")
        self._recorder = Recorder(config)
        there = [name for name in self._recorder.files if (folder / name).exists()]
        if there and not overwrite:
            raise FormatError(
                f"{folder / there[0]} exists; choose another folder, or overwrite it (--overwrite)."
            )
        self._folder = folder
        self._companion = Companion()
        self._files: list[Path] = []

    def write(self, step: Step) -> None:
        """Record a frame."""
        if step.info is not None:
            seconds = self._companion.seconds(step)
            self._recorder.add(step.frame, step.info, step.seconds, seconds)

    @property
    def result(self) -> str | None:
        """The files."""
        return f"{len(self._files)} figures in {self._folder}" if self._files else None

    def __enter__(self) -> Self:
        return self

    def __exit__(self, kind: type[BaseException] | None, *_: object) -> None:
        if kind is None or issubclass(kind, KeyboardInterrupt):
            self._files = self._recorder.save(self._folder)
