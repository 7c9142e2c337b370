"""The actor in which the reports of a part of a rig's cameras meet.

It starts the actors of its cameras, and starts them again when they or their nodes die. A report is
answered when it has been used, and when there is room for what follows from it: rows for the
program, and news for other parts. So whoever is slow slows cameras down, and no queue grows.
"""

from __future__ import annotations

import asyncio
from collections import defaultdict
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

import msgspec

from motes.cluster.remote_camera import RemoteCamera
from motes.cluster.rig_messages import Associated, PartEnded, PartNews, for_rows
from motes.mot.cameras.bordered import BorderedAssociation, News
from motes.mot.cameras.camera_report import CameraReport
from motes.mot.cameras.messages import CameraEnded, CameraMessage, Go, Message, NextFrame
from motes.mot.cameras.rig import next_report
from motes.mot.cameras.rig_config import Rig
from motes.sot.known_target import Target

ROOM = 1000
"""Number of reports that may wait for the program, and of news that may wait for another part."""


class HandoverActor:
    """Associates the objects of a part of a rig. Ray makes an actor of this class.

    Parameters
    ----------
    rig
        The whole rig.
    parts
        The names of the cameras of all parts.
    index
        The part.
    known_target
        Whether all cameras wait for the same known target.
    """

    def __init__(
        self, rig: Rig, parts: Sequence[tuple[str, ...]], index: int, *, known_target: bool = False
    ) -> None:
        self._association = BorderedAssociation(rig, parts, index, known_target=known_target)
        self._own = [camera for camera in rig.camera if camera.name in parts[index]]
        self._cameras: dict[str, RemoteCamera] = {}
        self._peers: Mapping[int, Any] = {}
        self._rows: list[PartNews] = []
        self._outbox: defaultdict[int, list[News]] = defaultdict(list)
        self._posting: dict[int, asyncio.Task[None]] = {}
        self._filled, self._moved = asyncio.Event(), asyncio.Event()
        self._ended = False

    async def start(
        self, peers: Mapping[int, Any], seed: int, epoch: float, target: Target | None
    ) -> None:
        """Start the cameras.

        Parameters
        ----------
        peers
            The actors of the other parts, by their indices.
        seed, epoch, target
            As for `CameraActor.watch`.
        """
        self._peers = peers
        for camera in self._own:
            one = RemoteCamera(camera, seed, epoch, target, self._put)
            self._cameras[camera.name] = one

    async def receive(self, name: str, life: int, number: int, data: bytes) -> bytes | None:
        """Take a message of a camera; return a `Go`, or None if a newer life of it has begun."""
        camera = self._cameras[name]
        if not await camera.turn(life, number):
            return None
        message = msgspec.msgpack.decode(data, type=Message)
        if isinstance(message, NextFrame):
            answer = camera.expect_go()
            self._put(camera.receive(message))
            return await answer
        self._put(camera.receive(message))
        await self._room()
        go = Go()
        if camera.live and isinstance(message, CameraReport):
            go = Go(self._association.arrivals(name, message.time))
        return msgspec.msgpack.encode(go)

    async def hear(self, data: bytes) -> None:
        """Take news of another part."""
        self._association.hear(msgspec.msgpack.decode(data, type=list[News]))
        self._post()

    async def take(self) -> bytes:
        """Wait for something to happen; return all that happened, as a list of `PartNews`."""
        while not self._rows:
            self._filled.clear()
            await self._filled.wait()
        rows, self._rows = self._rows, []
        self._moved.set()
        return msgspec.msgpack.encode(rows)

    def _put(self, news: Iterable[CameraMessage | CameraEnded]) -> None:
        """Use what a camera has sent, and keep what the program is to know."""
        self._rows += news
        cameras = [*self._cameras.values()]
        while (report := next_report(cameras, self._association)) is not None:
            identities = self._association.update(report)
            live = self._cameras[report.camera].live
            newest = self._association.newest
            self._rows.append(Associated(for_rows(report), identities, newest, live))
        if not self._ended and all(camera.over and not camera.reports for camera in cameras):
            self._ended = True
            self._rows.append(PartEnded(self._association.handed, self._association.merged))
        self._filled.set()
        self._post()

    def _post(self) -> None:
        """Send news to other parts; while a call to a part is open, its news gather."""
        for part, news in self._association.news().items():
            self._outbox[part] += news
            if part not in self._posting:
                self._posting[part] = asyncio.ensure_future(self._post_to(part))

    async def _post_to(self, part: int) -> None:
        import ray

        while self._outbox[part]:
            news, self._outbox[part] = self._outbox[part], []
            try:
                await self._peers[part].hear.remote(msgspec.msgpack.encode(news))
            except ray.exceptions.RayError:
                break  # the program ends when a part is lost
            self._moved.set()
        del self._posting[part]

    async def _room(self) -> None:
        """Wait until neither rows nor news are too many."""
        while len(self._rows) > ROOM or any(len(news) > ROOM for news in self._outbox.values()):
            self._moved.clear()
            await self._moved.wait()
