"""The workers of a session: they stay warm, and short tasks come first."""

from __future__ import annotations

import asyncio
import contextlib
import heapq
import itertools
import os
from collections.abc import AsyncIterator, Callable

from motes.studio.film_worker import FilmWorker, WorkerError
from motes.studio.workplace import Task

LONG = 400
"""Frames from which a task is long; one worker is always left for short ones."""


class WorkerPool:
    """Workers that open one film.

    Parameters
    ----------
    start
        Starts a worker.
    most
        How many there are at most.
    """

    def __init__(
        self, start: Callable[[], FilmWorker], most: int = (os.cpu_count() or 1) + 1
    ) -> None:
        self._start, self._most = start, most
        self._idle: list[FilmWorker] = []
        self._count = self._long = 0
        self._waiting: list[tuple[int, int, asyncio.Future[FilmWorker]]] = []
        self._numbers = itertools.count()
        self._all: set[FilmWorker] = set()
        self._closed = False

    def warm(self) -> None:
        """Start a worker, so that it is ready when it is needed."""
        if not self._count:
            self._idle.append(self._started())

    @contextlib.asynccontextmanager
    async def worker(self, frames: int = 0) -> AsyncIterator[FilmWorker]:
        """Return a worker for a task; the task with the fewest frames comes first.

        Raises
        ------
        WorkerError
            If the pool has been closed.
        """
        if self._closed:
            raise WorkerError("The session was closed meanwhile; open it again.")
        mine: asyncio.Future[FilmWorker] = asyncio.get_running_loop().create_future()
        heapq.heappush(self._waiting, (frames, next(self._numbers), mine))
        self._serve()
        try:
            worker = await mine
        except asyncio.CancelledError:
            if mine.done() and not mine.cancelled():
                self._take_back(mine.result(), frames)
            raise
        try:
            yield worker
        finally:
            self._take_back(worker, frames)

    async def run(self, task: Task, frames: int = 0) -> bytes:
        """Run a task in a worker, and return its data; `frames` is the length of the task."""
        async with self.worker(frames) as worker:
            return await worker.run(task)

    def close(self) -> None:
        """End all workers."""
        self._closed = True
        for worker in self._all:
            worker.close()
        for *_, waiter in self._waiting:
            waiter.cancel()

    def _started(self) -> FilmWorker:
        self._count += 1
        worker = self._start()
        self._all.add(worker)
        return worker

    def _take_back(self, worker: FilmWorker, frames: int) -> None:
        self._long -= frames >= LONG
        if worker.ended:
            self._count -= 1
            self._all.discard(worker)
        else:
            self._idle.append(worker)
        self._serve()

    def _serve(self) -> None:
        """Give workers to the tasks that wait, as far as there are any."""
        while self._waiting and not self._closed:
            frames, _, waiter = self._waiting[0]
            if waiter.cancelled():
                heapq.heappop(self._waiting)
                continue
            is_long = frames >= LONG
            if is_long and self._long >= self._most - 1:
                return
            if not self._idle and self._count >= self._most:
                return
            heapq.heappop(self._waiting)
            self._long += is_long
            waiter.set_result(self._idle.pop() if self._idle else self._started())
