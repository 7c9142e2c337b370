"""What a run is asked for: its film, what makes its results, and its outputs."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Generic, TypeVar

from motes.cli.annotated_video import AnnotatedVideo, Paint
from motes.cli.frame_loop import Sink
from motes.cli.option_groups import FrameOptions, OutputOptions
from motes.cli.outputs import STREAMED, DocumentOutput, MotOutput, Remembered, RowsOutput, format_of
from motes.core.config import Config
from motes.core.files import is_special, leftovers
from motes.correction.history import History
from motes.mot.analytics.real_units import RealUnits
from motes.mot.analytics.regions import Regions
from motes.rows.schema import Form
from motes.rows.writer import TrackWriter
from motes.video.film import Film
from motes.video.sources import Source

Configuration = TypeVar("Configuration", bound=Config)


@dataclass(frozen=True, kw_only=True)
class Request(Generic[Configuration]):
    """A film, its outputs, and how its results are made."""

    source: str
    frames: FrameOptions
    """The film and its frames, as they are given."""
    output: str | None
    outputs: OutputOptions
    """The file of the rows, - for standard output, or None without rows; and all options of
    outputs."""
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
    def remembered(self) -> Path | None:
        """The file of rows beside which a history is written; none of streams and documents."""
        output, form = self.output, self.outputs.format
        if output is None or output == "-" or is_special(output):
            return None
        return Path(output) if format_of(output, form) in STREAMED else None

    def pictures(self, film: Source | Film, painted: Paint) -> list[Sink]:
        """Return the output --overlay, whose pictures `painted` makes."""
        if (path := self.outputs.overlay) is None:
            return []
        stride, anew = self.frames.stride, self.overwrite
        return [AnnotatedVideo(path, film, stride, painted, overwrite=anew)]

    def rows(self, film: Source | Film, further: Sequence[str] = ()) -> list[Sink]:
        """Return what writes the rows, with further columns; none if they are not asked for.

        Raises a FormatError if a file exists and must not be overwritten, or cannot be made.
        """
        name, options = self.output, self.outputs
        if name is None:
            return []
        form = format_of(name, options.format)
        if form == "mot":
            return [MotOutput(name, options.overwrite)]
        if form not in STREAMED:
            return [DocumentOutput(name, form, film, options)]
        kind: Form = "csv" if form == "csv" else "jsonl"
        writer = TrackWriter(
            name, kind, overwrite=options.overwrite, resume=self.resume, further=further
        )
        return [RowsOutput(writer, options.label, resume=self.resume)]

    def remembered_rows(self, film: Source, further: Sequence[str] = ()) -> list[Sink]:
        """Return what writes the rows, after what writes their history."""
        outputs, rows = self.rows(film, further), self.remembered
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
        return [Remembered(rows, history, overwrite=overwrite, resume=resume), *outputs]
