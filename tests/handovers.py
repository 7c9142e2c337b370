"""Handover actors in one process, without a cluster: they get messages, and may end at any time."""

from __future__ import annotations

import asyncio
import types
from collections.abc import Sequence
from typing import Any

import msgspec

from motes.cluster.handover_actor import HandoverActor
from motes.cluster.handover_part import HandoverPart
from motes.cluster.rig_messages import Batch, PartNews, Restart
from motes.cluster.rig_streams import PartStream
from motes.mot.cameras.messages import Message
from motes.mot.cameras.rig_config import Rig


class Handovers:
    """The handover actors of a rig, and the program that takes their batches.

    As Ray does, it repeats calls that an actor has not answered when it ended.

    Attributes
    ----------
    news
        What the program got, by part.
    held
        What the program holds, by part.
    listening
        Whether the program takes batches.
    """

    def __init__(self, rig: Rig, parts: Sequence[tuple[str, ...]]) -> None:
        self._rig, self._parts = rig, parts
        self._numbers = {name: 0 for part in parts for name in part}
        self._part_of = {name: n for n, part in enumerate(parts) for name in part}
        self.news: list[list[PartNews | Restart]] = [[] for _ in parts]
        self.held = [PartStream(recorded=True) for _ in parts]
        self.listening = asyncio.Event()
        self.listening.set()
        self._actors: dict[int, HandoverActor] = {}
        self._ends: dict[int, asyncio.Future[None]] = {}
        self._programs: dict[int, asyncio.Task[None]] = {}
        for n in range(len(parts)):
            self._begin(n)

    def _begin(self, n: int) -> None:
        self._actors[n] = HandoverActor(self._rig, self._parts, n)
        self._ends[n] = asyncio.get_running_loop().create_future()
        self._programs[n] = asyncio.ensure_future(self._program(n))

    async def _program(self, n: int) -> None:
        actor, held = self._actors[n], self.held[n]
        peers = {index: self.peer(index) for index in range(len(self._parts))}
        data = await actor.take(held.count)
        while True:
            if data is None:
                data = await actor.start(peers, held.count, held.state, held.entries)
                continue
            batch = msgspec.msgpack.decode(data, type=Batch)
            held.hold(batch)
            self.news[n] += batch.news
            await self.listening.wait()
            data = await actor.take(held.count)

    def peer(self, n: int) -> Any:
        """Return the handle by which other parts call an actor."""

        def call(*args: Any) -> asyncio.Task[Any]:
            return asyncio.ensure_future(self._call(n, "hear", *args))

        return types.SimpleNamespace(hear=types.SimpleNamespace(remote=call))

    async def _call(self, n: int, method: str, *args: Any) -> Any:
        while True:
            end = self._ends[n]
            call = asyncio.ensure_future(getattr(self._actors[n], method)(*args))
            await asyncio.wait([call, end], return_when=asyncio.FIRST_COMPLETED)
            if not end.done():
                return call.result()
            call.cancel()  # what it has answered is lost as well

    def kill(self, n: int = 0) -> None:
        """End an actor, and begin another one, which knows nothing."""
        self._programs[n].cancel()
        for posting in self._actors[n]._posting.values():
            posting.cancel()
        self._ends[n].set_result(None)
        self._begin(n)

    def send(self, camera: str, message: Message, life: int = 0) -> asyncio.Task[bytes | None]:
        """Send the next message of a camera; return its answer."""
        number = self._numbers[camera]
        self._numbers[camera] += 1
        return self.send_as(number, camera, message, life)

    def send_as(
        self, number: int, camera: str, message: Message, life: int = 0
    ) -> asyncio.Task[bytes | None]:
        """Send a message with a number."""
        data = msgspec.msgpack.encode(message)
        call = self._call(self._part_of[camera], "receive", camera, life, number, data)
        return asyncio.ensure_future(call)

    def die(self, camera: str, life: int, why: str) -> asyncio.Task[None]:
        """End a camera's actor; the messages of the next one begin at 0 again."""
        self._numbers[camera] = 0
        return asyncio.ensure_future(self._call(self._part_of[camera], "died", camera, life, why))

    def part(self, n: int = 0) -> HandoverPart:
        """Return the state of an actor."""
        part = self._actors[n]._part
        assert part is not None
        return part


async def settled() -> None:
    """Let all tasks go on until each one waits for others."""
    for _ in range(60):
        await asyncio.sleep(0)
