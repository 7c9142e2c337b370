"""What pages ask about rows: doubtful frames, and layers. An answer goes to the page that asks."""

from __future__ import annotations

import asyncio
from collections.abc import Coroutine
from typing import Any, Protocol

import msgspec
import numpy as np

from motes.core.errors import ConfigError
from motes.studio import commands, messages
from motes.studio.clients import Client
from motes.studio.document import DrawnTarget
from motes.studio.plan import pass_to
from motes.studio.processes import WorkerError
from motes.studio.tables import STATUS, Table, pack
from motes.studio.tasks import Done, FindDoubts, LookAt, Task


class Ask(Protocol):
    """Lets a worker do a task of some frames."""

    async def __call__(self, task: Task, frames: int = 0) -> Done:
        """Return what the worker answers."""


class Questions:
    """The questions of a session that are not answered yet.

    Parameters
    ----------
    ask
        Lets a worker do a task.
    most
        Questions at once.
    """

    def __init__(self, ask: Ask, most: int) -> None:
        self._ask, self._most = ask, most
        self._tasks: set[asyncio.Task[None]] = set()
        self._looks: dict[Client, asyncio.Task[None]] = {}

    def __len__(self) -> int:
        return len(self._tasks)

    def leave(self, client: Client) -> None:
        """Forget the layers that a page has asked for."""
        if client in self._looks:
            self._looks.pop(client).cancel()

    def close(self) -> None:
        """Forget all questions."""
        for task in self._tasks:
            task.cancel()

    def doubts(self, client: Client, target: DrawnTarget, rows: Table | None, count: int) -> None:
        """Find the doubtful frames among the rows of an object's frames."""
        self._begin(self._find_doubts(client, target, rows, count))

    def look(self, client: Client, target: DrawnTarget, command: commands.Look) -> None:
        """Make layers of a frame; of a page's questions the newest one counts."""
        self.leave(client)
        self._looks[client] = self._begin(self._look(client, target, command))

    def _begin(self, work: Coroutine[Any, Any, None]) -> asyncio.Task[None]:
        if len(self._tasks) >= self._most:
            work.close()
            raise ConfigError(f"{len(self._tasks)} questions wait for answers; ask again later.")
        task = asyncio.create_task(work)
        self._tasks.add(task)
        task.add_done_callback(self._tasks.discard)
        return task

    async def _find_doubts(
        self, client: Client, target: DrawnTarget, rows: Table | None, count: int
    ) -> None:
        items: list[messages.DoubtfulFrame] = []
        if rows is not None:
            rows = rows[~np.isnan(rows[:, STATUS])]
            marks = [
                (frame, None if mark is None else tuple(mark))
                for frame, mark in target.marks.items()
            ]
            task = FindDoubts(pack(rows), len(target.tracker.cues), marks, count)
            try:
                done = await self._ask(task)
            except WorkerError as error:
                client.send(messages.Failure(str(error)))
                return
            items = msgspec.json.decode(done.data, type=list[messages.DoubtfulFrame])
        client.send(messages.DoubtList(target.object, items))

    async def _look(self, client: Client, target: DrawnTarget, command: commands.Look) -> None:
        run = pass_to(target, command.frame)
        task = LookAt(target.object, run, command.layers)
        try:
            done = await self._ask(task, frames=abs(run.stop - run.start))
        except WorkerError as error:
            client.send(messages.Failure(str(error)))
            return
        client.send(msgspec.json.decode(done.data, type=messages.Layers))
