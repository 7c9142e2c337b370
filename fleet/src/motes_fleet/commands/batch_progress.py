"""The progress of a batch: a bar or lines."""

from __future__ import annotations

import time
from typing import Self

from motes.cli import TerminalBar, log
from motes.core import counted
from motes_fleet.cluster import pool as pools
from motes_fleet.cluster.driver import BatchEvent
from motes_fleet.cluster.records import Record

INTERVAL = 30.0
"""Seconds between lines of progress where there is no terminal."""


class BatchProgress:
    """Counts what becomes of the jobs of a batch, and shows it."""

    def __init__(self, total: int) -> None:
        self.total = total
        self.kept = self.done = self.failed = self.frames = 0
        """Jobs that were done before, were done now, failed, and frames of those done now."""
        self.running = 0
        """Attempts that run."""
        self.written: str | None = None
        """The table that was written."""
        self._bar = TerminalBar("jobs", total)
        self._begun = self._shown = time.monotonic()

    def keep(self, record: Record) -> None:
        """Count a job that an earlier run has finished."""
        if record.status == "failed":
            self.failed += 1
        else:
            self.kept += 1
        self._show()

    def note(self, event: BatchEvent) -> None:
        """Count an event."""
        if isinstance(event, pools.Started):
            self.running += 1
        elif isinstance(event, pools.Again):
            self.running -= 1
            log(f"[{event.task.name}] attempt {event.task.attempt}: {event.error}")
        else:
            self.running -= 1
            self._finish(event)
        self._show()

    def _finish(self, record: Record) -> None:
        if record.status == "done":
            self.done += 1
            self.frames += record.frames
            if record.error is not None:  # what was strange
                log(f"[{record.name}] {record.error}")
        else:
            self.failed += 1
            log(f"[{record.name}] failed: {record.error}")

    @property
    def ended(self) -> int:
        """The number of jobs that need nothing more."""
        return self.kept + self.done + self.failed

    def _times(self) -> tuple[float, float, float]:
        """Return jobs a second, frames a second and the seconds left; 0 where unknown."""
        passed = max(time.monotonic() - self._begun, 1e-9)
        rate = (self.done + self.failed) / passed
        left = (self.total - self.ended) / rate if rate else 0.0
        return rate, self.frames / passed, left

    def _show(self) -> None:
        rate, frames, left = self._times()
        if self._bar.shown:
            speed = f"{rate:.2f} jobs/s {frames:.0f} frames/s"
            self._bar.update(completed=self.ended, rate=speed, state=f"{self.failed} failed")
        elif time.monotonic() - self._shown > INTERVAL:
            self._shown = time.monotonic()
            log(
                f"{self.ended} of {counted(self.total, 'job')}, {self.failed} failed, "
                f"{rate:.2f} jobs/s, {frames:.0f} frames/s, about {left:.0f} s left"
            )

    def summary(self, out: str) -> str:
        """Return one line on the whole run."""
        ended = "" if self.written else f"{self.ended} of "
        parts = [f"{ended}{counted(self.total, 'job')}", f"{self.done} done"]
        parts += [f"{self.kept} done before"] * bool(self.kept)
        parts += [f"{self.failed} failed", counted(self.frames, "frame")]
        where = [f"wrote {out}/{self.written}" if self.written else "the same command goes on"]
        where += [f"motes batch retry {out} --failed tries those again"] * bool(self.failed)
        return "; ".join([", ".join(parts), *where])

    def __enter__(self) -> Self:
        self._bar.__enter__()
        return self

    def __exit__(self, *exception: object) -> None:
        self._bar.__exit__(*exception)

    def numbers(self) -> dict[str, float]:
        """Return the number of jobs of each status."""
        return {
            "waiting": self.total - self.ended - self.running,
            "running": self.running,
            "done": self.done + self.kept,
            "failed": self.failed,
        }
