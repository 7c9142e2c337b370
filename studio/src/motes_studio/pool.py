"""The workers of a session: they stay warm, and short tasks come first."""

from __future__ import annotations

import asyncio
import contextlib
import itertools
import os
from collections.abc import AsyncIterator, Callable

from motes_studio.film_worker import FilmWorker, LaterError
from motes_studio.workplace import Task

LONG = 400
"""Frames from which a task is long; one worker is always left for short ones."""


class WorkerPool:
    """Workers that open one film: `most` of them at most, each of which `start` starts."""

    def __init__(
        self, start: Callable[[], FilmWorker], most: int = (os.cpu_count() or 1) + 1
    ) -> None:
        self._start, self._most = start, most
        self._all: set[FilmWorker] = set()
        self._idle: list[FilmWorker] = []
        self._long = 0
        self._waiting: set[tuple[int, int]] = set()
        """The tasks without a worker: their frames, and their numbers."""
        self._numbers = itertools.count()
        self._changed = asyncio.Event()
        self._closed = False

    def warm(self) -> None:
        """Start a worker, so that it is ready when it is needed."""
        if not self._all:
            self._idle.append(self._started())

    @contextlib.asynccontextmanager
    async def worker(self, frames: int = 0) -> AsyncIterator[FilmWorker]:
        """Return a worker for a task; the task with the fewest frames comes first.

        Raises
        ------
        LaterError
            If the pool has been closed.
        """
        mine, is_long = (frames, next(self._numbers)), frames >= LONG
        self._waiting.add(mine)
        try:
            while not self._closed and not (mine == min(self._waiting) and self._room(is_long)):
                self._changed.clear()
                await self._changed.wait()
        finally:
            self._waiting.remove(mine)
            self._changed.set()
        if self._closed:
            raise LaterError("The session was closed meanwhile; open it again.")
        worker = self._idle.pop() if self._idle else self._started()
        self._long += is_long
        try:
            yield worker
        finally:
            self._long -= is_long
            if worker.ended:
                self._all.discard(worker)
            else:
                self._idle.append(worker)
            self._changed.set()

    async def run(self, task: Task, frames: int = 0) -> bytes:
        """Run a task in a worker, and return its data; `frames` is the length of the task."""
        async with self.worker(frames) as worker:
            return await worker.run(task)

    def close(self) -> None:
        """End all workers."""
        self._closed = True
        for worker in self._all:
            worker.close()
        self._changed.set()

    def _started(self) -> FilmWorker:
        worker = self._start()
        self._all.add(worker)
        return worker

    def _room(self, is_long: bool) -> bool:
        """Return whether there is a worker for a task, or may be one more."""
        if is_long and self._long >= self._most - 1:
            return False
        return bool(self._idle) or len(self._all) < self._most
