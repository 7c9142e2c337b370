"""The progress bar of a run, and its statistics in one line."""

from __future__ import annotations

import sys
import time
from typing import TYPE_CHECKING, Any, Self

from motes.cli.messages import counted
from motes.core.track import Status

if TYPE_CHECKING:
    from motes.cli.moment import Moment

INTERVAL = 0.1
"""Seconds between updates of the progress bar."""
EVENTS = 6
"""Most losses and recoveries that are listed."""


class TerminalBar:
    """A progress bar on standard error; nothing if that is no terminal.

    Parameters
    ----------
    noun, total, done
        What is counted, how many there are, None if unknown, and how many are done already.
    quiet
        Whether nothing is shown on a terminal either.
    ticks
        Whether a thread shows the time that passes between updates.
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


class RunStatistics:
    """Statistics of a run with one object.

    Parameters
    ----------
    budget
        Whether the tracker chooses its number of particles.
    """

    def __init__(self, *, budget: bool = False) -> None:
        self._budget = budget
        self.frames = self._tracked = self._updates = 0
        self._seconds = 0.0
        self._particles = 0
        self._range = (sys.maxsize, 0)
        self._before: Moment | None = None
        self._events: list[str] = []

    @property
    def found(self) -> bool:
        """Whether the target was ever tracked."""
        return self._tracked > 0

    def add(self, moment: Moment) -> str:
        """Count a frame; return the state of the target."""
        self.frames += 1
        self._tracked += moment.status is Status.TRACKING
        if self._before is not None:
            if self._before.info is not None:  # the first frame includes the start
                self._updates += 1
                self._seconds += moment.seconds
                count = len(
                    self._before.info.weights if moment.info is None else moment.info.weights
                )
                self._particles += count
                self._range = min(self._range[0], count), max(self._range[1], count)
            if moment.status is Status.LOST:
                self._events.append(f"lost at frame {moment.frame.index}")
            if moment.status is Status.TRACKING and self._before.status is not Status.TRACKING:
                self._events.append(f"found at frame {moment.frame.index}")
        self._before = moment
        return f"{moment.status} {moment.track.confidence:.2f}" if moment.track else moment.status

    def __str__(self) -> str:
        parts = [counted(self.frames, "frame")]
        if self.frames:
            parts.append(f"tracked in {100 * self._tracked / self.frames:.1f} %")
        if self._updates:
            parts.append(f"tracker {1000 * self._seconds / self._updates:.2f} ms a frame")
        if self._updates and self._budget:
            (least, most), mean = self._range, self._particles / self._updates
            varied = f"{least} to {most} particles, {mean:.0f} on average"
            parts.append(varied if least < most else f"{most} particles")
        parts += self._events[:EVENTS]
        if len(self._events) > EVENTS:
            parts.append(f"{len(self._events) - EVENTS} more changes")
        return ", ".join(parts)
