"""A run: its frames become moments, which all of its outputs take."""

from __future__ import annotations

import sys
import time
from abc import abstractmethod
from collections.abc import Callable, Generator, Iterator, Mapping, Sequence
from contextlib import AbstractContextManager, ExitStack, closing, suppress
from dataclasses import dataclass, field, replace
from typing import Any, Protocol, Self

from msgspec import structs

from motes.cli.exit_codes import DONE, NOT_FOUND
from motes.cli.streams import log
from motes.core import interrupts
from motes.core.errors import AwayError, MotesError, counted
from motes.core.frame import Frame
from motes.core.interrupts import check, deferred
from motes.core.track import Track
from motes.mot.analytics.event import Event
from motes.rows.schema import FrameRow
from motes.sot.algorithm import StepInfo
from motes.video.film import Film
from motes.video.newest import Newest
from motes.video.prefetch import prefetch
from motes.video.sources import Source

INTERVAL = 0.1
"""Seconds between updates of the progress bar."""


class TerminalBar:
    """A progress bar on standard error; nothing if that is no terminal.

    `total` is None if it is unknown, and `done` are there already. With `ticks`, a thread shows the
    time that passes between updates.
    """

    def __init__(
        self,
        noun: str,
        total: int | None,
        done: int = 0,
        *,
        quiet: bool = False,
        ticks: bool = True,
    ) -> None:
        self._bar: Any = None
        if quiet or not sys.stderr.isatty():
            return
        from rich.console import Console
        from rich.progress import BarColumn, Progress, TextColumn, TimeRemainingColumn

        self._bar = Progress(
            TextColumn(f"{{task.completed:.0f}}/{'?' if total is None else total} {noun}"),
            BarColumn(bar_width=None),
            TextColumn("{task.fields[rate]}"),
            TimeRemainingColumn(compact=True),
            TextColumn("{task.fields[state]}", markup=False),
            console=Console(stderr=True),
            auto_refresh=ticks,
            transient=True,
            expand=True,
        )
        self._task = self._bar.add_task("", total=total, completed=done, rate="", state="")

    @property
    def shown(self) -> bool:
        """Whether there is a bar."""
        return self._bar is not None

    def update(self, **values: Any) -> None:
        """Show how many are done (`completed`), the `rate`, and the `state` of the run."""
        if self._bar is not None:
            self._bar.update(self._task, **values)

    def __enter__(self) -> Self:
        if self._bar is not None:
            self._bar.start()
        return self

    def __exit__(self, *_: object) -> None:
        if self._bar is not None:
            self._bar.stop()


class FrameProgress(TerminalBar):
    """The progress of a run over frames; `count` is None if their number is unknown."""

    def __init__(self, count: int | None, *, quiet: bool = False) -> None:
        super().__init__("frames", count, quiet=quiet, ticks=False)
        self._frames = self._before = 0
        self._at = time.perf_counter()

    def count(self, state: str) -> None:
        """Count a frame; update the bar if the last update is older than `INTERVAL`."""
        self._frames += 1
        passed = time.perf_counter() - self._at
        if passed < INTERVAL:
            return
        rate = f"{(self._frames - self._before) / passed:.0f} frames/s"
        self.update(completed=self._frames, rate=rate, state=state, refresh=True)
        self._before, self._at = self._frames, self._at + passed


@dataclass(frozen=True, slots=True)
class Moment:
    """The result of a frame."""

    frame: Frame
    """The frame."""
    tracks: Sequence[Track] = ()
    """Its objects. The target of a tracker is the only one, also where it is nowhere."""
    info: StepInfo | None = None
    """The report of the tracker of one target; None before it has one."""
    seconds: float = 0.0
    """Time of the tracker."""
    events: Sequence[Event] = ()
    """What several objects do."""
    undecided: int | None = None
    """The first frame that may still get an event; None if no frame so far may."""
    totals: Mapping[str, int] = field(default_factory=dict)
    """Number of events so far, as `EventCounter.totals`."""

    def labeled(self, label: str | None) -> Moment:
        """Return the moment in which objects without a class have this one, if it is given."""
        if label is None:
            return self
        return replace(
            self, tracks=[structs.replace(each, label=each.label or label) for each in self.tracks]
        )

    @property
    def rows(self) -> FrameRow:
        """The rows of the frame."""
        return FrameRow(self.frame.index, self.frame.time, tuple(self.tracks))

    @property
    def target(self) -> Track:
        """The track of the one target; it is searched for, and nowhere, before there is one."""
        (target,) = self.tracks
        return target


Moments = Callable[[Iterator[Frame]], Generator[Moment, None, None]]
"""Makes the results of a run from its frames."""


class Sink(AbstractContextManager[object], Protocol):
    """An output: it takes the result of each frame, and is closed as a context manager."""

    @abstractmethod
    def write(self, moment: Moment, /) -> None:
        """Add a frame."""

    @property
    def result(self) -> str | None:
        """The name of what was written, for the summary; None for nothing."""
        return None

    def __enter__(self) -> Self:
        return self

    @abstractmethod
    def __exit__(self, *exception: Any) -> None:
        """Finish what was written."""


class Tally:
    """Counts the frames of a run; as text, its statistics in one line."""

    def __init__(self) -> None:
        self.frames = 0
        """The number of frames so far."""

    def add(self, moment: Moment) -> str:
        """Count a frame that is written; return the state of the run, for the progress bar."""
        del moment
        self.frames += 1
        return ""

    def remarks(self) -> Sequence[str]:
        """Return the lines after the summary."""
        return ()

    @property
    def missing(self) -> str | None:
        """What to say if nothing was ever found; None where something was."""
        return None

    def __str__(self) -> str:
        return counted(self.frames, "frame")


def run(
    film: Source,
    outputs: Sequence[Sink],
    moments: Moments,
    tally: Tally,
    *,
    label: str | None = None,
    quiet: bool = False,
) -> int:
    """Write the result of each frame into all outputs, close them, and print a summary.

    Objects without a class get `label`.

    Raises a MotesError if the source cannot be read any more, or an output not be written. Where a
    live source is away for good, the outputs are finished before. A thread decodes the frames
    ahead, and leaves out those of a live source that the results are too slow for. The outputs are
    opened here, before the first frame, and `moments` is closed before the film. The summary is
    printed also where an error ends the run. Returns the exit code; an interrupt before the first
    frame leaves no file.
    """
    interrupted: KeyboardInterrupt | None = None
    away: AwayError | None = None
    try:
        with (
            ExitStack() as opened,
            Newest(film) if film.live else prefetch(film) as frames,
            ExitStack() as reading,
        ):
            reading.callback(film.stop)
            for output in outputs:
                opened.enter_context(output)
            making = opened.enter_context(closing(moments(iter(frames))))
            with FrameProgress(film.frame_count, quiet=quiet) as bar:

                def take(moment: Moment) -> None:
                    moment = moment.labeled(label)
                    with deferred():
                        for output in outputs:
                            output.write(moment)
                        state = tally.add(moment)
                    bar.count(state)

                try:
                    for moment in making:
                        take(moment)
                        check()
                except KeyboardInterrupt as interrupt:
                    with suppress(KeyboardInterrupt, StopIteration):  # what is open is told
                        take(making.throw(interrupt))
                    if not tally.frames:
                        raise
                    interrupted = interrupt
                except AwayError as error:  # a live source has no other end
                    away = error
                except BrokenPipeError:  # whoever reads standard output has left
                    if len(outputs) == 1:
                        raise
                    interrupted = interrupts.Interrupt(interrupts.PIPE)
    except KeyboardInterrupt as interrupt:
        interrupted = interrupt
    except MotesError:
        summarize(tally, film, outputs, None)
        raise
    summarize(tally, film, outputs, interrupted)
    if away is not None:
        raise away
    if interrupted:
        return interrupts.code(interrupted)
    if tally.missing is not None:
        log(f"error: {tally.missing}")
        return NOT_FOUND
    return DONE


def summarize(
    tally: Tally,
    film: Source | Film,
    outputs: Sequence[Sink],
    interrupted: KeyboardInterrupt | None,
) -> None:
    """Print a line on a run that is over, if it did not fail before the first frame, and remarks.

    The problems of the source and the files of the outputs are added.
    """
    if not tally.frames:
        if interrupted:
            log(f"{interrupts.word(interrupted)}0 frames; nothing is written.")
        return
    written = [output.result for output in outputs if output.result is not None]
    line = [f"{interrupts.word(interrupted)}{tally}"]
    if written:
        line.append("wrote " + ", ".join(written))
    if film.report.problems:
        line.append(f"{film.name}: {film.report.problems}")
    log("; ".join(line) + ".")
    for text in tally.remarks():
        log(text)
