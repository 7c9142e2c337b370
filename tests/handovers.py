"""A handover actor in one process, without a cluster: it gets messages, and may end at any time."""

from __future__ import annotations

import asyncio
from typing import Any

import msgspec

from motes.cluster.handover_actor import HandoverActor
from motes.cluster.rig_messages import Batch, GroupNews, Restart
from motes.cluster.rig_streams import GroupStream
from motes.mot.cameras.messages import Message
from motes.mot.cameras.rig_config import Rig


class Meeting:
    """The handover actor of a rig, and the program that takes its batches.

    As Ray does, it repeats calls that the actor has not answered when it ended.

    Attributes
    ----------
    news
        What the program got.
    held
        What the program holds.
    listening
        Whether the program takes batches.
    """

    def __init__(self, rig: Rig) -> None:
        self._rig = rig
        self._numbers = {camera.name: 0 for camera in rig.camera}
        self.news: list[GroupNews | Restart] = []
        self.held = GroupStream(recorded=True)
        self.listening = asyncio.Event()
        self.listening.set()
        self._begin()

    def _begin(self) -> None:
        self._actor = HandoverActor(self._rig)
        self._end: asyncio.Future[None] = asyncio.get_running_loop().create_future()
        self._program = asyncio.ensure_future(self._take_all(self._actor))

    async def _take_all(self, actor: HandoverActor) -> None:
        held = self.held
        data = await actor.take(held.count)
        while True:
            if data is None:
                data = await actor.start(held.count, held.state, held.entries)
                continue
            batch = msgspec.msgpack.decode(data, type=Batch)
            held.hold(batch)
            self.news += batch.news
            await self.listening.wait()
            data = await actor.take(held.count)

    async def _call(self, method: str, *args: Any) -> Any:
        while True:
            end = self._end
            call = asyncio.ensure_future(getattr(self._actor, method)(*args))
            await asyncio.wait([call, end], return_when=asyncio.FIRST_COMPLETED)
            if not end.done():
                return call.result()
            call.cancel()  # what it has answered is lost as well

    def kill(self) -> None:
        """End the actor, and begin another one, which knows nothing."""
        self._program.cancel()
        self._end.set_result(None)
        self._begin()

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
        return asyncio.ensure_future(self._call("receive", camera, life, number, data))

    def die(self, camera: str, life: int, why: str) -> asyncio.Task[None]:
        """End a camera's actor; the messages of the next one begin at 0 again."""
        self._numbers[camera] = 0
        return asyncio.ensure_future(self._call("died", camera, life, why))


async def settled() -> None:
    """Let all tasks go on until each one waits for others."""
    for _ in range(60):
        await asyncio.sleep(0)
