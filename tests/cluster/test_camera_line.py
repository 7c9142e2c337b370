"""Order, lives and back-pressure between a camera and its handover, without a cluster."""

from __future__ import annotations

import asyncio
import types
from collections.abc import Callable, Coroutine, Sequence
from typing import Any

import msgspec
import numpy as np
import pytest

import loops
from handovers import Meeting, settled
from motes.cluster import rig_streams
from motes.cluster.camera_actor import OPEN, ActorLine
from motes.cluster.camera_actors import reason
from motes.cluster.rig_messages import Associated, Batch, GroupEnded, Restart
from motes.cluster.rig_on_ray import ClusterRig, Handover
from motes.cluster.rig_streams import GroupStream, Numbers
from motes.core.geometry import Box
from motes.core.track import Status
from motes.mot.cameras.camera_report import CameraReport, ObjectReport
from motes.mot.cameras.messages import (
    CameraEnded,
    CameraMessage,
    CameraReady,
    Go,
    Message,
    NextFrame,
)
from motes.mot.cameras.reidentification import CAMERA_TIMEOUT
from motes.mot.cameras.rig_config import Camera, Rig

GO = msgspec.msgpack.encode(Go())


class Calls:
    """Stands for Ray: calls of a handover, which the test answers."""

    def __init__(self) -> None:
        self.answers: list[bytes | None] = []
        self.most = self._open = 0
        self.exceptions = types.SimpleNamespace(RayError=OSError)

    def call(self, name: str, life: int, number: int, data: bytes) -> int:
        """Count a call."""
        self._open += 1
        self.most = max(self.most, self._open)
        return number

    def get(self, number: int) -> bytes | None:
        """Answer a call."""
        self._open -= 1
        return self.answers.pop(0) if self.answers else GO

    def wait(self, numbers: list[int], timeout: float) -> tuple[list[int], list[int]]:
        """Find nothing answered."""
        return [], numbers


def test_a_camera_has_few_unanswered_messages() -> None:
    ray = Calls()
    line = ActorLine(ray, ray.call, "hall", 0)
    for frame in range(50):
        line.send(CameraReport("hall", frame, frame / 25, ()))
    assert ray.most == OPEN


def test_a_camera_whose_newer_life_has_begun_ends() -> None:
    ray = Calls()
    ray.answers = [None]
    line = ActorLine(ray, ray.call, "hall", 0)
    line.send(CameraReport("hall", 0, 0.0, ()))
    with pytest.raises(BrokenPipeError):
        line.settle()


def seen(camera: str, frame: int, time: float, own: int = 1) -> CameraReport:
    """Return a report of one object."""
    box, look = Box(10, 10, 20, 40), np.full(8, 0.125, np.float32).tobytes()
    found = ObjectReport(own, Status.TRACKING, box, 0.9, None, True, histogram=look)
    return CameraReport(camera, frame, time, (found,), (320, 240))


def go(test: Callable[[Meeting], Coroutine[None, None, None]], *names: str) -> None:
    """Run a test with a handover actor of some cameras."""

    async def run() -> None:
        await test(Meeting(Rig(tuple(Camera(name, "") for name in names))))

    loops.run(run(), 600)


def reports_of(meeting: Meeting) -> list[Associated]:
    """Return the reports that the program got."""
    return [each for each in meeting.news if isinstance(each, Associated)]


def test_messages_are_used_in_their_order() -> None:
    async def test(one: Meeting) -> None:
        messages: list[Message] = [CameraReady("hall", True)]
        messages += [CameraReport("hall", n, n / 25, ()) for n in range(4)]
        answers = [one.send_as(n, "hall", messages[n]) for n in (2, 4, 0, 3, 1)]
        assert await asyncio.gather(*answers) == [GO] * 5
        assert [each.report.frame for each in reports_of(one)] == [0, 1, 2, 3]

    go(test, "hall")


def test_an_earlier_life_is_refused() -> None:
    async def test(one: Meeting) -> None:
        await one.send("hall", CameraReady("hall", True))
        early = one.send_as(7, "hall", CameraReport("hall", 7, 0.0, ()))
        await settled()
        await one.die("hall", 0, "its node died")
        assert await early is None
        assert await one.send_as(1, "hall", CameraReport("hall", 0, 0.0, ())) is None
        await one.die("hall", 0, "its node died")  # Ray repeats calls
        assert await one.send_as(0, "hall", CameraReady("hall", True), life=1) == GO
        assert [each for each in one.news if isinstance(each, Restart)] == [
            Restart("hall", 1, CAMERA_TIMEOUT)
        ]

    go(test, "hall")


def test_identities_and_frames_go_on_in_the_next_life() -> None:
    """Another process numbers its objects and frames from the start again."""

    async def test(one: Meeting) -> None:
        await one.send("hall", CameraReady("hall", True))
        for n in range(3):
            await one.send("hall", seen("hall", n, n / 25))
        await one.die("hall", 0, "its node died")
        await one.send("hall", CameraReady("hall", True), life=1)
        for n in range(2):
            await one.send("hall", seen("hall", n, 8 + n / 25), life=1)
        reports = reports_of(one)
        assert [each.report.frame for each in reports] == [0, 1, 2, 3, 4]
        assert [[*each.identities.items()] for each in reports] == [[(1, 1)]] * 3 + [[(2, 1)]] * 2
        said = [each.text for each in one.news if isinstance(each, CameraMessage)]
        assert said[0] == "its node died. It is started again, with growing pauses."
        assert said[1].startswith("it is back after")

    go(test, "hall")


def test_nothing_is_answered_before_the_program_has_it() -> None:
    """So a program that does not listen slows cameras down, and no answer has to be taken back."""

    async def test(one: Meeting) -> None:
        await one.send("hall", CameraReady("hall", True))
        await settled()
        one.listening.clear()
        answers = [one.send("hall", CameraReport("hall", n, n / 25, ())) for n in range(OPEN)]
        await settled()
        assert not any(answer.done() for answer in answers)
        one.listening.set()
        assert await asyncio.gather(*answers) == [GO] * OPEN
        assert [each.report.frame for each in reports_of(one)] == [*range(OPEN)]

    go(test, "hall")


def test_recordings_go_in_step() -> None:
    async def test(one: Meeting) -> None:
        for name in ("one", "two"):
            await one.send(name, CameraReady(name, False))
        first = one.send("one", NextFrame(0.0))
        await settled()
        assert not first.done()  # the other one may have an earlier frame
        second = one.send("two", NextFrame(0.0))
        assert await first == GO
        await one.send("one", seen("one", 0, 0.0))
        await one.send("one", CameraEnded("one", 1))
        assert await second == GO
        await one.send("two", seen("two", 0, 0.0))
        await one.send("two", CameraEnded("two", 1))
        assert [each.report.camera for each in reports_of(one)] == ["one", "two"]
        assert isinstance(one.news[-1], GroupEnded)

    go(test, "one", "two")


def test_rows_of_several_groups_are_in_the_order_of_time() -> None:
    rig = object.__new__(ClusterRig)
    rig._order = {"one": 0, "two": 1, "live": 2}
    rig._streams = [
        GroupStream(recorded=True),
        GroupStream(recorded=True),
        GroupStream(recorded=False),
    ]
    rig._numbers, rig.handover = Numbers(3), Handover()
    first, second, live = (stream.news for stream in rig._streams)
    first += [Associated(seen("one", n, n / 10), {1: 1}, 1, False) for n in range(2)]
    assert list(rig._ready()) == []  # something earlier may come
    live.append(Associated(seen("live", 0, 9.0), {1: 1}, 1, True))
    first.appendleft(CameraMessage("one", "it is here."))
    assert [*map(_name, rig._ready())] == ["it is here.", "live"]
    second += [Associated(seen("two", 0, 0.0), {1: 1}, 2, False), GroupEnded(1, {2: 1})]
    first += [GroupEnded(2, {})]
    reports = [each for each in rig._ready() if isinstance(each, tuple)]
    assert [(report.camera, found) for report, found in reports] == [
        ("one", {1: 2}),
        ("two", {1: 3}),
        ("one", {1: 2}),
    ]
    assert rig.handover.handed == 3
    assert rig.handover.merged == {4: 3}


class Batches:
    """Stands for Ray and for an actor whose news come in batches."""

    exceptions = types.SimpleNamespace(
        RayError=OSError, ActorUnavailableError=TimeoutError, ObjectLostError=TimeoutError
    )

    def __init__(self, *batches: list[Any]) -> None:
        self._batches, self.taken = [*batches], 0
        self.take = self.start = self

    def options(self, **_: object) -> Batches:
        """Take options of a call."""
        return self

    def remote(self, *_: object) -> Batches:
        """Take a batch."""
        return self

    def wait(self, calls: list[Batches], timeout: float) -> tuple[list[Batches], None]:
        """Find one call answered: this actor is the fastest."""
        able = [call for call in calls if call._batches]
        return sorted(able, key=lambda call: call is not self)[:1], None

    def get(self, call: Batches) -> bytes:
        """Return the news of a call."""
        call.taken += 1
        return msgspec.msgpack.encode(Batch(call.taken, b"", call._batches.pop(0)))

    def look(self) -> Sequence[Any]:
        """Find all cameras alive."""
        return ()


def test_a_recording_that_is_ahead_waits_for_the_others(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(rig_streams, "ROOM", 10)
    rig = object.__new__(ClusterRig)
    rig._order, rig._numbers, rig.handover = {"one": 0, "two": 1}, None, Handover()
    rig._streams = [GroupStream(recorded=True), GroupStream(recorded=True)]
    fast = [[Associated(seen("one", n, n / 10), {1: 1}, 1, False)] for n in range(50)]
    ahead = Batches(*fast, [GroupEnded(0, {})])
    late = Batches([Associated(seen("two", 0, 2.05), {1: 2}, 2, False)], [GroupEnded(0, {})])
    rig._actors, rig._ray = [ahead, late], ahead
    rig._cameras = ahead  # type: ignore[assignment]
    order = []
    for news in rig:
        order.append(_name(news))
        assert ahead.taken <= len(order) + 12
    assert order == ["one"] * 21 + ["two"] + ["one"] * 29


def _name(news: Any) -> str:
    return str(news[0].camera if isinstance(news, tuple) else news.text)


def test_identities_of_groups_are_numbered_in_one_row() -> None:
    numbers = Numbers(2)
    report = seen("one", 0, 0.0)
    assert numbers.of(0, Associated(report, {1: 1}, 1, False)) == {1: 1}
    assert numbers.of(1, Associated(report, {1: 1, 2: 2}, 2, False)) == {1: 2, 2: 3}
    assert numbers.of(0, Associated(report, {1: 1, 2: 3}, 3, False)) == {1: 1, 2: 5}
    assert numbers.named(0, {3: 1}) == {5: 1}
    assert numbers.named(1, {2: 1}) == {3: 2}


def test_the_end_of_an_actor_is_one_short_line() -> None:
    lost = OSError(
        "The actor died.\n\tpid: 7\nThe actor died because its node has died. Node Id: 1"
    )
    assert reason(lost) == "its node died"
    assert reason(OSError("The actor\ndied")) == "its process ended"
