"""The workers of a session: which task gets the next one, and what becomes of those that wait."""

import asyncio
from typing import cast

import pytest

from motes_studio.film_worker import FilmWorker, WorkerError
from motes_studio.pool import WorkerPool


class Idle:
    """A worker that does nothing."""

    def __init__(self) -> None:
        self.ended = False

    def close(self) -> None:
        """End."""
        self.ended = True


class Tasks:
    """Tasks of a pool, which last until they are let go; `running` are those with a worker."""

    def __init__(self, most: int) -> None:
        self.pool = WorkerPool(self._start, most)
        self.running: list[str] = []
        self.workers: list[Idle] = []
        self._ends: dict[str, asyncio.Event] = {}
        self.tasks: dict[str, asyncio.Task[None]] = {}

    def _start(self) -> FilmWorker:
        self.workers.append(Idle())
        return cast(FilmWorker, self.workers[-1])

    async def _run(self, name: str, frames: int) -> None:
        async with self.pool.worker(frames):
            self.running.append(name)
            await self._ends[name].wait()

    async def begin(self, **frames: int) -> None:
        """Begin tasks of some frames."""
        for name, count in frames.items():
            self._ends[name] = asyncio.Event()
            self.tasks[name] = asyncio.create_task(self._run(name, count))
        await settle()

    async def end(self, name: str) -> None:
        """Let a task end."""
        self._ends[name].set()
        await settle()


async def settle() -> None:
    """Let all tasks come to where they wait."""
    for _ in range(20):
        await asyncio.sleep(0)


def test_the_task_with_the_fewest_frames_comes_first() -> None:
    async def tried() -> None:
        tasks = Tasks(most=1)
        await tasks.begin(first=0, large=30, small=10, same=10)
        for name in ("first", "small", "same", "large"):
            assert tasks.running[-1] == name
            await tasks.end(name)
        assert len(tasks.workers) == 1

    asyncio.run(tried())


def test_a_worker_that_has_ended_is_replaced() -> None:
    async def tried() -> None:
        tasks = Tasks(most=1)
        tasks.pool.warm()
        await tasks.begin(first=0, second=0)
        tasks.workers[0].ended = True
        await tasks.end("first")
        assert tasks.running == ["first", "second"]
        assert len(tasks.workers) == 2

    asyncio.run(tried())


def test_who_waits_may_leave_and_is_told_of_the_end() -> None:
    async def tried() -> None:
        tasks = Tasks(most=1)
        await tasks.begin(first=0, left=10, second=20, last=30)
        tasks.tasks["left"].cancel()
        await tasks.end("first")
        assert tasks.running == ["first", "second"]
        tasks.pool.close()
        await settle()
        with pytest.raises(WorkerError, match="closed meanwhile"):
            await tasks.tasks["last"]
        with pytest.raises(WorkerError, match="closed meanwhile"):
            await tasks.pool.run(lambda _: b"")
        assert tasks.workers[0].ended

    asyncio.run(tried())
