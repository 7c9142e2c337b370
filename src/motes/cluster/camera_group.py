"""The state of a handover actor, which follows from what the actor was sent and from nothing else.

So the same entries in the same order give the same identities and the same answers, in any process.
"""

from __future__ import annotations

from collections.abc import Iterator

import msgspec

from motes.cluster.remote_camera import RemoteCamera
from motes.cluster.rig_messages import (
    Associated,
    Died,
    Entry,
    GroupEnded,
    GroupNews,
    Received,
    Restart,
    for_rows,
)
from motes.mot.cameras.camera_report import CameraReport
from motes.mot.cameras.messages import Go, Message, NextFrame
from motes.mot.cameras.reidentification import CrossCameraAssociation
from motes.mot.cameras.rig import next_report
from motes.mot.cameras.rig_config import Rig


class CameraGroup:
    """Associates the objects of cameras that are joined.

    Parameters
    ----------
    rig
        The cameras, and how they are joined.
    known_target
        Whether all cameras wait for the same known target.

    Attributes
    ----------
    cameras
        The cameras, by their names.
    count
        The number of entries that it has used.
    """

    def __init__(self, rig: Rig, *, known_target: bool = False) -> None:
        self._association = CrossCameraAssociation(rig, known_target=known_target)
        self.cameras = {camera.name: RemoteCamera(camera.name) for camera in rig.camera}
        self.count = 0
        self._ended = False

    def use(self, entry: Entry) -> list[GroupNews | Restart]:
        """Use an entry; return what follows for the program."""
        self.count += 1
        news = [*(self._receive(entry) if isinstance(entry, Received) else self._restart(entry))]
        cameras = self.cameras.values()
        if not self._ended and all(camera.over and not camera.reports for camera in cameras):
            self._ended = True
            news.append(GroupEnded(self._association.handed, self._association.merged))
        return news

    def _receive(self, entry: Received) -> Iterator[GroupNews | Restart]:
        camera, number = self.cameras[entry.camera], self.cameras[entry.camera].turn
        camera.clock, camera.turn = entry.time, number + 1
        message = msgspec.msgpack.decode(entry.data, type=Message)
        if isinstance(message, NextFrame):
            camera.expect_go(number)
        yield from camera.receive(message)
        yield from self._associate()
        if not isinstance(message, NextFrame):
            go = Go()
            if camera.live and isinstance(message, CameraReport):
                go = Go(self._association.arrivals(camera.name, message.time))
            camera.answer(number, go)

    def _restart(self, entry: Died) -> Iterator[GroupNews | Restart]:
        camera = self.cameras[entry.camera]
        camera.clock = entry.time
        yield from camera.fail(entry.why)
        if camera.due is not None:
            pause = camera.due - camera.clock
            camera.begin_life()
            yield Restart(camera.name, camera.life, pause)
        yield from self._associate()

    def _associate(self) -> Iterator[GroupNews]:
        """Use all reports that may be used by now."""
        cameras = [*self.cameras.values()]
        while (report := next_report(cameras, self._association)) is not None:
            identities = self._association.update(report)
            live = self.cameras[report.camera].live
            yield Associated(for_rows(report), identities, self._association.newest, live)
