"""A job, and those that see what happens."""

from __future__ import annotations

import time
from collections.abc import Iterable, Iterator
from typing import Literal, NamedTuple, Protocol

from motes.studio.messages import JobStatus, OpenFilm, Overlay, Progress
from motes.studio.pool import WorkerPool
from motes.studio.store import Store


class Audience(Protocol):
    """Those that see what happens."""

    def rows(self, number: int, frames: Iterable[int]) -> None:
        """Note that rows of an object have changed."""

    def reset(self, number: int) -> None:
        """Note that all rows of an object are void."""

    def overlay(self, overlay: Overlay) -> None:
        """Take what a tracker sees in a frame."""

    def progress(self, progress: Progress) -> None:
        """Take the state of a job."""

    def scene(self, *, reset: bool = False) -> None:
        """Note that many-object mode has more; with `reset`, earlier parts are void."""


class Desk(NamedTuple):
    """What all jobs of a session share.

    Attributes
    ----------
    session, store
        Where rows are kept.
    film
        The film.
    pool
        The workers.
    numbers
        Of jobs.
    audience
        Those that see what happens.
    """

    session: str
    store: Store
    film: OpenFilm
    pool: WorkerPool
    numbers: Iterator[int]
    audience: Audience


class StudioJob:
    """Objects that are tracked together, or a run of the many-object mode."""

    def __init__(
        self,
        number: int,
        objects: Iterable[int],
        *,
        kind: Literal["track", "watch"] = "track",
        left: int = 0,
    ) -> None:
        self.number, self.objects, self._kind = number, [*objects], kind
        self.status: JobStatus = "waiting"
        self.error: str | None = None
        self.done, self.left = 0, left
        self._since = time.monotonic()

    @property
    def active(self) -> bool:
        """Whether it has not ended."""
        return self.status in ("waiting", "running", "paused")

    def progress(self) -> Progress:
        """Return its state."""
        seconds = time.monotonic() - self._since
        rate = self.done / seconds if self.done and seconds > 0 else None
        left = self.left / rate if rate and self.active else None
        return Progress(
            self.number, self._kind, self.objects, self.done, self.done + self.left, rate, left,
            self.status, self.error,
        )  # fmt: skip
