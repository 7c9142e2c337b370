"""The line between a camera's actor and the program: keys, back-pressure and lives, without Ray."""

from __future__ import annotations

import contextlib
import socket
import threading
import types
from collections.abc import Callable, Iterable, Iterator
from typing import Any, Self

import msgspec
import numpy as np
import pytest

from motes import Box, Status
from motes_fleet.cameras import rig_camera
from motes_fleet.cameras.camera_report import (
    CameraEnded,
    CameraMessage,
    CameraReady,
    CameraReport,
    Message,
    ObjectReport,
)
from motes_fleet.cameras.rig import RigRunner
from motes_fleet.cameras.rig_config import Camera, Rig
from motes_fleet.cluster import camera_actor
from motes_fleet.cluster.camera_actor import ClusterCamera, pipe_of

HALL = Camera("hall", "", node="upstairs")


class Died(Exception):  # noqa: N818
    """Stands for the errors of Ray."""


class Actors:
    """Stands for Ray: its actors are threads that do what the test says, one life after another.

    Attributes
    ----------
    lives
        What the actor of each life does with the address of the program and its key.
    dead
        Whether each life has ended.
    """

    exceptions = types.SimpleNamespace(RayError=Died)
    util = types.SimpleNamespace(get_node_ip_address=lambda: "127.0.0.1")

    def __init__(self, *lives: Callable[[tuple[str, int], bytes], None]) -> None:
        self.lives, self.dead = lives, list[bool]()
        self.watch = types.SimpleNamespace(remote=self._watch)

    def remote(self, _: object) -> Self:
        """Make an actor, or its class."""
        return self

    def options(self, **_: object) -> Self:
        """Take options."""
        return self

    def _watch(self, *arguments: Any) -> int:
        number = len(self.dead)
        self.dead.append(False)
        work = self.lives[number]

        def run() -> None:
            work(*arguments[-2:])
            self.dead[number] = True

        threading.Thread(target=run, daemon=True).start()
        return number

    def wait(self, ends: list[int], timeout: float) -> tuple[list[int], list[int]]:
        """Return which lives have ended."""
        return [end for end in ends if self.dead[end]], []

    def get(self, end: int) -> None:
        """Say why an actor has ended."""
        raise Died("The actor died because its node has died.")

    def kill(self, actor: object) -> None:
        """Do nothing: the threads end by themselves."""


@pytest.fixture(autouse=True)
def _impatient(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(camera_actor, "LOOK", 0.01)
    monkeypatch.setattr(rig_camera, "CAMERA_TIMEOUT", 0.01)


def sends(messages: Iterable[Message]) -> Callable[[tuple[str, int], bytes], None]:
    """Return what an actor does that sends some messages, then ends."""

    def work(program: tuple[str, int], key: bytes) -> None:
        connection = socket.create_connection(program)
        connection.sendall(key)
        with contextlib.suppress(OSError), pipe_of(connection) as pipe:
            for message in messages:
                pipe.send_bytes(msgspec.msgpack.encode(message))

    return work


def watching(ray: Actors) -> RigRunner:
    """Return a program that watches the hall."""

    def start(camera: Camera, *arguments: Any) -> ClusterCamera:
        return ClusterCamera(ray, camera, *arguments)

    return RigRunner(Rig((HALL,)), start=start)


def seen(frame: int, time: float) -> CameraReport:
    """Return a report of one object."""
    box, look = Box(10, 10, 20, 40), np.full(8, 0.125, np.float32).tobytes()
    found = ObjectReport(1, Status.TRACKING, box, 0.9, None, True, histogram=look, look=look)
    return CameraReport("hall", frame, time, (found,), (320, 240))


def test_identities_and_frames_go_on_in_the_next_life() -> None:
    """Another process numbers its objects and frames from the start again."""
    ready, end = CameraReady("hall", True), CameraEnded("hall", 1)
    first = sends([ready, *(seen(n, n / 25) for n in range(3))])
    second = sends([ready, *(seen(n, 80 + n / 25) for n in range(2)), end])
    with watching(Actors(first, second)) as rig:
        news = [*rig]
    reports = [each for each in news if isinstance(each, tuple)]
    assert [report.frame for report, _ in reports] == [0, 1, 2, 3, 4]
    assert [dict(found) for _, found in reports] == [{1: 1}] * 3 + [{2: 2}] * 2
    said = [each.text for each in news if isinstance(each, CameraMessage)]
    assert said[0] == "its node died. It is started again, with growing pauses."
    assert said[1].startswith("it is back after")
    assert news[-1] == end


def test_who_has_no_key_is_not_let_in() -> None:
    ready, end = CameraReady("hall", True), CameraEnded("hall", 1)
    honest = sends([ready, seen(0, 0.0), end])

    def work(program: tuple[str, int], key: bytes) -> None:
        sends([ready, seen(7, 0.0), end])(program, bytes(len(key)))
        socket.create_connection(program).close()
        honest(program, key)

    with watching(Actors(work)) as rig:
        assert [each[0].frame for each in rig if isinstance(each, tuple)] == [0]


def test_a_camera_waits_for_a_program_that_does_not_listen() -> None:
    """So what it sends is never old, and no queue grows."""
    sent = list[int]()

    def reports() -> Iterator[Message]:
        yield CameraReady("hall", True)
        for n in range(5000):
            sent.append(n)
            yield seen(n, n / 25)
        yield CameraEnded("hall", 1)

    with watching(Actors(sends(reports()))) as rig:
        used = 0
        for news in rig:
            if isinstance(news, tuple):
                used += 1
                assert len(sent) - used < 2000
    assert used == len(sent) == 5000
