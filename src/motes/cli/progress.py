"""The progress bar of a run."""

from __future__ import annotations

import sys
import time
from typing import Any, Self

INTERVAL = 0.1
"""Seconds between updates of the progress bar."""


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
