"""What pages see of a session, and when each part of it has changed last.

Time is the number of changes so far. So a page needs to know only up to when it has seen all, and
gets what is newer, as it is then: a slow page needs no more memory than a fast one.
"""

from __future__ import annotations

import asyncio
import time
from collections.abc import Iterable, Iterator
from typing import Literal

import numpy as np

from motes_studio import tables
from motes_studio.messages import JobStatus, Overlay, Progress, Rows
from motes_studio.tables import CUES, FINAL, FRAME, Table

ROWS = 500
"""Rows of a message at most."""
KEPT = 20
"""Jobs that have ended and are still listed."""


class StudioJob:
    """Objects that are tracked together, or a run of the many-object mode."""

    def __init__(
        self, number: int, kind: Literal["track", "watch"], objects: Iterable[int]
    ) -> None:
        self.number, self.kind, self.objects = number, kind, [*objects]
        self.status: JobStatus = "waiting"
        self.error: str | None = None
        self.note: str | None = None
        self.done = self.left = self.changed = 0
        self._since = time.monotonic()

    @property
    def active(self) -> bool:
        """Whether it has not ended."""
        return self.status in ("waiting", "running")

    def progress(self) -> Progress:
        """Return its state."""
        seconds = time.monotonic() - self._since
        rate = self.done / seconds if self.done and seconds > 0 else None
        left = self.left / rate if rate and self.active else None
        return Progress(
            self.number, self.kind, self.objects, self.done, self.done + self.left, rate, left,
            self.status, self.error, self.note,
        )  # fmt: skip


class ShownRows:
    """The rows of an object, as pages see them."""

    def __init__(self, frames: int, cues: int, now: int) -> None:
        self.begun = self.last = now
        """When earlier rows became void, and when any row changed last."""
        self.changed = np.zeros(frames, np.int64)
        """When each row changed last, (frames,), 0 where there is none."""
        self.table = np.zeros((frames, CUES + cues))
        """The rows, one for each frame of the film."""


class Board:
    """The parts of a session that pages see, each with the number of its last change."""

    def __init__(self, frames: int) -> None:
        self._frames = frames
        self.now = 1
        """The number of changes so far."""
        self.state = self.scene = self.scene_begun = 1
        """When the session changed, when the many-object mode had more, and when its run began."""
        self.jobs: dict[int, StudioJob] = {}
        self.overlays: dict[int, tuple[int, Overlay]] = {}
        """What trackers saw last, by object."""
        self.news: set[asyncio.Event] = set()
        """Set at each change."""
        self._shown: dict[int, ShownRows] = {}
        self._begun_jobs = 0

    def _change(self) -> int:
        """Return the time of a change, of which all pages are told."""
        self.now += 1
        for each in self.news:
            each.set()
        return self.now

    def change_state(self) -> None:
        """Let pages see the session anew."""
        self.state = self._change()

    def extend_scene(self, *, reset: bool = False) -> None:
        """Let pages see what the many-object mode has found; with `reset`, it begins anew."""
        self.scene = self._change()
        if reset:
            self.scene_begun = self.scene

    def begin_job(self, kind: Literal["track", "watch"], objects: Iterable[int]) -> StudioJob:
        """Return a new job; of those that have ended, only the last ones stay."""
        ended = [number for number, job in self.jobs.items() if not job.active]
        for number in ended[:-KEPT]:
            del self.jobs[number]
        self._begun_jobs += 1
        job = self.jobs[self._begun_jobs] = StudioJob(self._begun_jobs, kind, objects)
        return job

    def progress(self, job: StudioJob) -> None:
        """Let pages see the state of a job."""
        job.changed = self._change()

    def overlay(self, overlay: Overlay) -> None:
        """Let pages see what a tracker sees in a frame."""
        self.overlays[overlay.object] = self._change(), overlay

    def void(self, number: int, cues: int) -> None:
        """Let all rows of an object be void; further ones have this number of cues."""
        self.overlays.pop(number, None)
        self._shown[number] = ShownRows(self._frames, cues, self._change())

    def forget(self, number: int) -> None:
        """Forget an object."""
        self.overlays.pop(number, None)
        del self._shown[number]

    def show(self, number: int, table: Table) -> None:
        """Let pages see rows of an object, which replace those of their frames."""
        shown, frames = self._shown[number], table[:, FRAME].astype(int)
        shown.table[frames] = table
        shown.last = shown.changed[frames] = self._change()

    def outdate(self, number: int, first: int, last: int) -> None:
        """Mark rows as no result any more; they stay until there are better ones."""
        shown = self._shown[number]
        old = first + np.flatnonzero(shown.table[first : last + 1, FINAL] == 1)
        if len(old):
            shown.table[old, FINAL] = 0
            shown.last = shown.changed[old] = self._change()

    def rows(self, number: int, first: int, last: int) -> Table:
        """Return the rows of an object that are shown, from one frame to another."""
        shown, part = self._shown[number], slice(first, last + 1)
        return shown.table[part][shown.changed[part] > 0]

    def rows_since(self, seen: int) -> Iterator[Rows]:
        """Return the rows of all objects that have changed from a time until now."""
        changes = [
            (number, shown, shown.begun > seen, np.flatnonzero(shown.changed > seen))
            for number, shown in self._shown.items()
            if shown.last > seen
        ]

        def messages() -> Iterator[Rows]:
            for number, shown, reset, frames in changes:
                if reset:
                    yield Rows(number, [], reset=True)
                for i in range(0, len(frames), ROWS):
                    yield Rows(number, tables.rows(shown.table[frames[i : i + ROWS]]))

        return messages()
