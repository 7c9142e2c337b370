"""The actor in which the reports of a connected group of cameras meet.

Nothing leaves it before the program holds what it follows from: a report is answered when the
program has taken the batch with it. So when the process ends, the next one starts from what the
program holds, and cameras repeat what was not answered: Ray calls it again. Whoever is slow slows
cameras down, and no queue grows.
"""

from __future__ import annotations

import asyncio
import pickle
import time
from collections import defaultdict
from collections.abc import Sequence
from functools import partial
from typing import Any, TypeVar

import msgspec

from motes.cluster.camera_group import CameraGroup
from motes.cluster.rig_messages import Batch, Died, Entry, GroupNews, Received, Restart
from motes.mot.cameras.rig_config import Rig

T = TypeVar("T")
LOG = 1000
"""Number of entries after which the program gets the state in their place."""
Call = tuple[str, int, int]
"""A call of a camera: its name, its life, and the number of the message."""


class HandoverActor:
    """Associates the objects of a group of cameras. Ray makes an actor of this class.

    Its parameters are those of `CameraGroup`.
    """

    def __init__(self, rig: Rig, *, known_target: bool = False) -> None:
        self._new = partial(CameraGroup, rig, known_target=known_target)
        self._group: CameraGroup | None = None
        self._started, self._changed = asyncio.Event(), asyncio.Event()
        self._early: defaultdict[str, dict[int, bytes]] = defaultdict(dict)
        self._calls: dict[Call, asyncio.Future[bytes | None]] = {}
        self._deaths: list[tuple[int, asyncio.Future[None]]] = []
        """Calls of `died`, and what `CameraGroup.count` was with each."""
        self._entries: list[Entry] = []
        self._news: list[GroupNews | Restart] = []
        self._logged = 0
        self._batch = Batch(0, b"", [])
        self._answered: list[Call] = []

    async def start(
        self, count: int, state: bytes | None, entries: Sequence[bytes]
    ) -> bytes | None:
        """Begin, or go on where an earlier process was; return the first batch, as `take` does.

        Parameters
        ----------
        count, state, entries
            What the program holds: the number of all entries, the newest `Batch.state`, and the
            `Batch.entries` since.
        """
        if self._group is None:
            group: CameraGroup = self._new() if state is None else pickle.loads(state)
            for data in entries:
                for entry in msgspec.msgpack.decode(data, type=list[Entry]):
                    group.use(entry)
                    self._logged += 1
            self._group, self._batch = group, Batch(count, b"", [])
            self._started.set()
        return await self.take(count)

    async def receive(self, name: str, life: int, number: int, data: bytes) -> bytes | None:
        """Take a message of a camera; return a `Go`, or None if a newer life of it has begun.

        The messages of a life are used in the order of their numbers, each one once.
        """
        group = await self._begun()
        camera = group.cameras[name]
        if life != camera.life:
            return None
        answer = self._calls.setdefault((name, life, number), _future())
        early = self._early[name]
        if number >= camera.turn:
            early[number] = data
        while (following := early.pop(camera.turn, None)) is not None:
            self._use(Received(name, following, time.time()))
        self._changed.set()
        return await answer

    async def died(self, name: str, life: int, why: str) -> None:
        """Note that the actor of a camera has ended; return when the program holds this."""
        group = await self._begun()
        camera = group.cameras[name]
        if camera.over or life != camera.life:
            return
        self._use(Died(name, why, time.time()))
        self._early.pop(name, None)
        for call in [each for each in self._calls if each[:2] == (name, life)]:
            _settle(self._calls.pop(call), None)  # it seems dead, and may still send
        held = _future()
        self._deaths.append((group.count, held))
        await held

    async def take(self, count: int) -> bytes | None:
        """Wait for something to happen; return a `Batch`, or None if this process has no state.

        Parameters
        ----------
        count
            `Batch.count` of the last batch that the program holds.
        """
        if self._group is None:
            return None
        if count == self._batch.count:
            self._release(self._group)
            await self._something(self._group)
            self._close(self._group)
        return msgspec.msgpack.encode(self._batch)

    async def _begun(self) -> CameraGroup:
        """Wait for the state; return it."""
        await self._started.wait()
        assert self._group is not None
        return self._group

    def _use(self, entry: Entry) -> None:
        assert self._group is not None
        self._news += self._group.use(entry)
        self._entries.append(entry)
        self._changed.set()

    async def _something(self, group: CameraGroup) -> None:
        """Wait until there are entries, or calls that have an answer."""
        while True:
            self._answered = [
                call for call in self._calls if call[2] in group.cameras[call[0]].answers
            ]
            if self._entries or self._answered:
                return
            self._changed.clear()
            await self._changed.wait()

    def _close(self, group: CameraGroup) -> None:
        """Make a batch of what has happened."""
        self._logged += len(self._entries)
        state = None
        if self._logged >= LOG:
            state, self._logged, self._entries = pickle.dumps(group), 0, []
        entries = msgspec.msgpack.encode(self._entries)
        self._batch = Batch(group.count, entries, self._news, state)
        self._entries, self._news = [], []

    def _release(self, group: CameraGroup) -> None:
        """Send what follows from the batch, since the program holds it."""
        for call in self._answered:
            if (answer := self._calls.pop(call, None)) is not None:  # its camera has not died since
                _settle(answer, group.cameras[call[0]].answers[call[2]])
        self._answered = []
        while self._deaths and self._deaths[0][0] <= self._batch.count:
            _settle(self._deaths.pop(0)[1], None)


def _future() -> asyncio.Future[Any]:
    return asyncio.get_running_loop().create_future()


def _settle(future: asyncio.Future[T], result: T) -> None:
    """Set the result of a future, unless the call that waited for it was canceled."""
    if not future.done():
        future.set_result(result)
