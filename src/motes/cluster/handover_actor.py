"""The actor in which the reports of a part of a rig's cameras meet.

Nothing leaves it before the program holds what it follows from. A report is answered, and news go
to other parts, when the program has taken the batch with the report. So when the process ends, the
next one starts from what the program holds, and senders repeat what was not answered: Ray calls it
again. Whoever is slow slows cameras down, and no queue grows.
"""

from __future__ import annotations

import asyncio
import pickle
import time
from collections import defaultdict
from collections.abc import Mapping, Sequence
from functools import partial
from typing import Any, TypeVar

import msgspec

from motes.cluster.handover_part import HandoverPart
from motes.cluster.rig_messages import Batch, Died, Entry, Heard, PartNews, Received, Restart
from motes.mot.cameras.bordered import News
from motes.mot.cameras.rig_config import Rig

T = TypeVar("T")
ROOM = 1000
"""Number of news that may wait for another part, and of reports that may wait in the program."""
LOG = 1000
"""Number of entries after which the program gets the state in their place."""
Call = tuple[str, int, int]
"""A call of a camera: its name, its life, and the number of the message."""


class HandoverActor:
    """Associates the objects of a part of a rig. Ray makes an actor of this class.

    Its parameters are those of `HandoverPart`.
    """

    def __init__(
        self, rig: Rig, parts: Sequence[tuple[str, ...]], index: int, *, known_target: bool = False
    ) -> None:
        self._new = partial(HandoverPart, rig, parts, index, known_target=known_target)
        self._index = index
        self._part: HandoverPart | None = None
        self._peers: Mapping[int, Any] = {}
        self._started, self._changed = asyncio.Event(), asyncio.Event()
        self._early: defaultdict[str, dict[int, bytes]] = defaultdict(dict)
        self._calls: dict[Call, asyncio.Future[bytes | None]] = {}
        self._uses: list[tuple[int, asyncio.Future[None]]] = []
        self._entries: list[Entry] = []
        self._news: list[PartNews | Restart] = []
        self._logged = 0
        self._batch = Batch(0, b"", [])
        self._answered: list[Call] = []
        self._news_ends: dict[int, int] = {}
        """The numbers that follow those of the news for other parts, in the last batch."""
        self._sendable: dict[int, int] = {}
        """The same in the last batch that the program holds."""
        self._posting: dict[int, asyncio.Task[None]] = {}

    async def start(
        self, peers: Mapping[int, Any], count: int, state: bytes | None, entries: Sequence[bytes]
    ) -> bytes | None:
        """Begin, or go on where an earlier process was; return the first batch, as `take` does.

        Parameters
        ----------
        peers
            The actors of the other parts, by their indices.
        count, state, entries
            What the program holds: the number of all entries, the newest `Batch.state`, and the
            `Batch.entries` since.
        """
        if self._part is None:
            part: HandoverPart = self._new() if state is None else pickle.loads(state)
            for data in entries:
                for entry in msgspec.msgpack.decode(data, type=list[Entry]):
                    part.use(entry)
                    self._logged += 1
            self._part, self._peers, self._batch = part, peers, Batch(count, b"", [])
            self._news_ends = self._ends()
            self._started.set()
        return await self.take(count)

    async def receive(self, name: str, life: int, number: int, data: bytes) -> bytes | None:
        """Take a message of a camera; return a `Go`, or None if a newer life of it has begun.

        The messages of a life are used in the order of their numbers, each one once.
        """
        part = await self._begun()
        camera = part.cameras[name]
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
        """Note that the actor of a camera has ended."""
        part = await self._begun()
        camera = part.cameras[name]
        if camera.over or life != camera.life:
            return
        self._use(Died(name, why, time.time()))
        self._early.pop(name, None)
        for call in [each for each in self._calls if each[:2] == (name, life)]:
            _settle(self._calls.pop(call), None)  # it seems dead, and may still send
        await self._held()

    async def hear(self, index: int, first: int, end: int, data: bytes) -> None:
        """Take the news of another part that have numbers from `first` to before `end`."""
        part = await self._begun()
        if not part.has_heard(index, end):
            self._use(Heard(index, first, data))
            await self._held()

    async def take(self, count: int) -> bytes | None:
        """Wait for something to happen; return a `Batch`, or None if this process has no state.

        Parameters
        ----------
        count
            `Batch.count` of the last batch that the program holds.
        """
        if self._part is None:
            return None
        if count == self._batch.count:
            self._release()
            await self._something()
            self._close()
        return msgspec.msgpack.encode(self._batch)

    async def _begun(self) -> HandoverPart:
        """Wait for the state; return it."""
        await self._started.wait()
        assert self._part is not None
        return self._part

    def _use(self, entry: Entry) -> None:
        assert self._part is not None
        self._news += self._part.use(entry)
        self._entries.append(entry)
        self._changed.set()

    async def _held(self) -> None:
        """Wait until the program holds all entries that there are now."""
        assert self._part is not None
        held = _future()
        self._uses.append((self._part.count, held))
        await held

    async def _something(self) -> None:
        """Wait until there are entries, or answers that may be sent."""
        self._answered = self._answerable()
        while not self._entries and not self._answered:
            self._changed.clear()
            await self._changed.wait()
            self._answered = self._answerable()

    def _answerable(self) -> list[Call]:
        """Return the calls that have an answer; none while another part has too much to hear."""
        assert self._part is not None
        cameras = self._part.cameras
        if any(len(box.news) > ROOM for box in self._part.outbox.values()):
            return []
        return [call for call in self._calls if call[2] in cameras[call[0]].answers]

    def _close(self) -> None:
        """Make a batch of what has happened."""
        assert self._part is not None
        self._logged += len(self._entries)
        state = None
        if self._logged >= LOG:
            state, self._logged, self._entries = pickle.dumps(self._part), 0, []
        entries = msgspec.msgpack.encode(self._entries)
        self._batch = Batch(self._part.count, entries, self._news, state)
        self._entries, self._news = [], []
        self._news_ends = self._ends()

    def _release(self) -> None:
        """Send what follows from the batch, since the program holds it."""
        assert self._part is not None
        for call in self._answered:
            if (answer := self._calls.pop(call, None)) is not None:  # its camera has not died since
                _settle(answer, self._part.cameras[call[0]].answers[call[2]])
        self._answered = []
        while self._uses and self._uses[0][0] <= self._batch.count:
            _settle(self._uses.pop(0)[1], None)
        self._sendable = self._news_ends
        for part in self._sendable:
            if part not in self._posting:
                self._posting[part] = asyncio.ensure_future(self._post_to(part))

    def _ends(self) -> dict[int, int]:
        """Return the numbers that follow those of the news for other parts."""
        assert self._part is not None
        return {part: box.end for part, box in self._part.outbox.items()}

    async def _post_to(self, part: int) -> None:
        """Send the news that may be sent; while a call is open, news gather."""
        import ray

        assert self._part is not None
        box = self._part.outbox[part]
        while (end := self._sendable[part]) > box.first:
            news: list[News] = box.news[: end - box.first]
            data = msgspec.msgpack.encode(news)
            try:
                await self._peers[part].hear.remote(self._index, box.first, end, data)
            except ray.exceptions.RayError:
                break  # the program ends when a part is lost for ever
            box.drop(end)
            self._changed.set()
        del self._posting[part]


def _future() -> asyncio.Future[Any]:
    return asyncio.get_running_loop().create_future()


def _settle(future: asyncio.Future[T], result: T) -> None:
    """Set the result of a future, unless the call that waited for it was canceled."""
    if not future.done():
        future.set_result(result)
