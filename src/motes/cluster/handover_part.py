"""The state of a handover actor, which follows from what the actor was sent and from nothing else.

So the same entries in the same order give the same identities and the same answers, in any process.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence

import msgspec

from motes.cluster.remote_camera import RemoteCamera
from motes.cluster.rig_messages import (
    Associated,
    Died,
    Entry,
    Heard,
    PartEnded,
    PartNews,
    Received,
    Restart,
    for_rows,
)
from motes.mot.cameras.bordered import BorderedAssociation, News
from motes.mot.cameras.camera_report import CameraReport
from motes.mot.cameras.messages import Go, Message, NextFrame
from motes.mot.cameras.rig import next_report
from motes.mot.cameras.rig_config import Rig


class Outbox:
    """News for another part that it may not have yet; `first` is the number of the first one."""

    def __init__(self) -> None:
        self.first, self.news = 0, list[News]()

    @property
    def end(self) -> int:
        """The number that follows that of the last one."""
        return self.first + len(self.news)

    def drop(self, before: int) -> None:
        """Drop news that the other part has."""
        del self.news[: before - self.first]
        self.first = max(self.first, before)


class HandoverPart:
    """Associates the objects of a part of a rig.

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

    Attributes
    ----------
    cameras
        Its cameras, by their names.
    outbox
        News for other parts, by their indices.
    count
        The number of entries that it has used.
    """

    def __init__(
        self, rig: Rig, parts: Sequence[tuple[str, ...]], index: int, *, known_target: bool = False
    ) -> None:
        self._association = BorderedAssociation(rig, parts, index, known_target=known_target)
        own = [camera.name for camera in rig.camera if camera.name in parts[index]]
        self.cameras = {name: RemoteCamera(name) for name in own}
        self.outbox: dict[int, Outbox] = {}
        self.count = 0
        self._heard: Counter[int] = Counter()
        self._ended = False

    def use(self, entry: Entry) -> list[PartNews | Restart]:
        """Use an entry; return what follows for the program."""
        self.count += 1
        news: list[PartNews | Restart] = []
        if isinstance(entry, Received):
            news += self._receive(entry)
        elif isinstance(entry, Died):
            news += self._restart(entry)
        else:
            self._hear(entry)
        if not self._ended and all(each.over and not each.reports for each in self._cameras()):
            self._ended = True
            news.append(PartEnded(self._association.handed, self._association.merged))
        for part, border in self._association.news().items():
            self.outbox.setdefault(part, Outbox()).news += border
        return news

    def has_heard(self, part: int, end: int) -> bool:
        """Return whether all news of a part before a number were used."""
        return self._heard[part] >= end

    def _cameras(self) -> list[RemoteCamera]:
        return [*self.cameras.values()]

    def _receive(self, entry: Received) -> list[PartNews]:
        camera, number = self.cameras[entry.camera], self.cameras[entry.camera].turn
        camera.clock, camera.turn = entry.time, number + 1
        message = msgspec.msgpack.decode(entry.data, type=Message)
        if isinstance(message, NextFrame):
            camera.expect_go(number)
        news = [*camera.receive(message), *self._associate()]
        if not isinstance(message, NextFrame):
            go = Go()
            if camera.live and isinstance(message, CameraReport):
                go = Go(self._association.arrivals(camera.name, message.time))
            camera.answer(number, go)
        return news

    def _restart(self, entry: Died) -> list[PartNews | Restart]:
        camera = self.cameras[entry.camera]
        camera.clock = entry.time
        news: list[PartNews | Restart] = [*camera.fail(entry.why)]
        if camera.due is not None:
            pause = camera.due - camera.clock
            camera.begin_life()
            news.append(Restart(camera.name, camera.life, pause))
        return [*news, *self._associate()]

    def _hear(self, entry: Heard) -> None:
        """Use news that were not heard before: another part repeats what may be lost."""
        news = msgspec.msgpack.decode(entry.data, type=list[News])
        self._association.hear(news[self._heard[entry.part] - entry.first :])
        self._heard[entry.part] = entry.first + len(news)

    def _associate(self) -> list[PartNews]:
        """Use all reports that may be used by now."""
        news: list[PartNews] = []
        while (report := next_report(self._cameras(), self._association)) is not None:
            identities = self._association.update(report)
            live = self.cameras[report.camera].live
            newest = self._association.newest
            news.append(Associated(for_rows(report), identities, newest, live))
        return news
