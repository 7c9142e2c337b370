"""The actor of a camera: it runs on a node that reaches the camera, and sends reports, no frames.

A camera has at most `OPEN` messages that the handover has not answered. Then it waits. A live
source drops its pictures meanwhile and counts them, so nothing queues up.
"""

from __future__ import annotations

import contextlib
import os
import time
from collections import deque
from collections.abc import Sequence
from typing import Any

import msgspec

from motes.mot.cameras.camera_loop import watch_camera
from motes.mot.cameras.camera_report import Arrival
from motes.mot.cameras.messages import Go, Message, NextFrame
from motes.mot.cameras.rig_config import Camera
from motes.sot.known_target import KnownTarget

OPEN = 4
"""Largest number of unanswered messages of a camera."""


class CameraActor:
    """Watches a camera. Ray makes an actor of this class.

    Parameters
    ----------
    handover
        The handle of the actor that gets the reports.
    name
        The camera's, which Ray's dashboard shows.
    life
        How often the camera was started before; the handover listens to its newest life only.
    """

    def __init__(self, handover: Any, name: str, life: int) -> None:
        self._handover, self._name, self._life = handover, name, life

    def __repr__(self) -> str:
        return f"camera {self._name}, life {self._life}"

    def watch(self, camera: Camera, seed: int, epoch: float, target: KnownTarget | None) -> None:
        """Watch a camera until it ends, or until nobody listens any more.

        Parameters
        ----------
        camera, seed, target
            As for `watch_camera`.
        epoch
            The reading of `time.time` at time 0 of live frames: clocks of nodes must agree.
        """
        import ray

        os.dup2(2, 1)
        origin = time.monotonic() - (time.time() - epoch)
        line = ActorLine(ray, self._handover.receive.remote, camera.name, self._life)
        with contextlib.suppress(BrokenPipeError):
            watch_camera(camera, seed, origin, target, line)
            line.settle()


class ActorLine:
    """The line from a camera to the handover: each message is a call, each answer holds arrivals.

    Parameters
    ----------
    ray
        The module.
    call
        Calls the handover with the camera's name, life, the message's number and its bytes.
    name, life
        The camera's.
    """

    def __init__(self, ray: Any, call: Any, name: str, life: int) -> None:
        self._ray, self._call, self._from = ray, call, (name, life)
        self._sent = 0
        self._open: deque[Any] = deque()
        self._announced: Any = None
        self._arrivals: list[Arrival] = []

    def send(self, message: Message) -> None:
        """Send a message, once few enough are unanswered."""
        while len(self._open) >= OPEN:
            self._settle_oldest()
        call = self._call(*self._from, self._sent, msgspec.msgpack.encode(message))
        self._sent += 1
        if isinstance(message, NextFrame):
            self._announced = call  # which is answered when the recording may go on
        else:
            self._open.append(call)

    def go(self) -> Go:
        """Wait for the answer to a `NextFrame`."""
        return self._answer(self._announced)

    def arrivals(self) -> Sequence[Arrival]:
        """Return the arrivals in the answers that have come."""
        while self._open and self._ray.wait([self._open[0]], timeout=0)[0]:
            self._settle_oldest()
        found, self._arrivals = self._arrivals, []
        return found

    def settle(self) -> None:
        """Wait for all answers."""
        while self._open:
            self._settle_oldest()

    def _settle_oldest(self) -> None:
        self._arrivals += self._answer(self._open.popleft()).arrivals

    def _answer(self, call: Any) -> Go:
        """Wait for an answer; raise a BrokenPipeError if another life of the camera has begun."""
        try:
            data = self._ray.get(call)
        except self._ray.exceptions.RayError as error:
            raise BrokenPipeError(str(error)) from None
        if data is None:
            raise BrokenPipeError("A newer life of this camera has begun")
        return msgspec.msgpack.decode(data, type=Go)
