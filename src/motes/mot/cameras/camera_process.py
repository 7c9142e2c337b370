"""The process of a camera: `CameraProcess` in the main process, `_serve` in its own."""

from __future__ import annotations

import multiprocessing
import os
import queue
import threading
import time
from collections.abc import Iterator, Sequence
from contextlib import suppress
from multiprocessing.connection import Connection, wait

import msgspec

from motes.core.worker_processes import cause, started
from motes.mot.cameras.camera_loop import watch_camera
from motes.mot.cameras.camera_report import Arrival
from motes.mot.cameras.messages import CameraEnded, CameraMessage, Go, Message
from motes.mot.cameras.rig_camera import RigCamera
from motes.mot.cameras.rig_config import Camera
from motes.sot.known_target import KnownTarget


class CameraProcess(RigCamera):
    """A camera in a process of its own, seen from the main process."""

    def __init__(
        self, camera: Camera, seed: int, origin: float, target: KnownTarget | None = None
    ) -> None:
        self._args = camera, seed, origin, target
        super().__init__(camera.name)

    def _start(self) -> None:
        self.process, self.pipe = started(_serve, *self._args)

    def _send(self, arrivals: tuple[Arrival, ...]) -> None:
        with suppress(OSError):  # a process that died is noticed when it is listened to
            self.pipe.send_bytes(msgspec.msgpack.encode(Go(arrivals)))

    def revive(self) -> None:
        """Start it again if that is due."""
        if self.due is not None and time.monotonic() >= self.due:
            self.pipe.close()
            self.start()

    def listen(self) -> Iterator[CameraMessage | CameraEnded]:
        """Receive its next message; yield it unless it is a report, which waits for its time."""
        try:
            message = msgspec.msgpack.decode(self.pipe.recv_bytes(), type=Message)
        except (EOFError, OSError):
            self.process.join()
            yield from self.fail(f"its process ended with {cause(self.process.exitcode)}")
            return
        yield from self.receive(message)


class _PipeLine:
    """The line from a camera's process to the main process."""

    def __init__(self, pipe: Connection) -> None:
        self._pipe = pipe
        self._inbox: queue.SimpleQueue[Go] = queue.SimpleQueue()
        threading.Thread(target=_receive, args=(pipe, self._inbox), daemon=True).start()

    def send(self, message: Message) -> None:
        self._pipe.send_bytes(msgspec.msgpack.encode(message))

    def go(self) -> Go:
        return self._inbox.get()

    def arrivals(self) -> Sequence[Arrival]:
        found: list[Arrival] = []
        while not self._inbox.empty():
            found += self._inbox.get().arrivals
        return found


def _serve(
    pipe: Connection, camera: Camera, seed: int, origin: float, target: KnownTarget | None
) -> None:
    """Watch a camera until it ends."""
    os.dup2(2, 1)  # standard output is for rows
    with suppress(BrokenPipeError):
        watch_camera(camera, seed, origin, target, _PipeLine(pipe))


def _receive(pipe: Connection, inbox: queue.SimpleQueue[Go]) -> None:
    """Receive what the main process sends; end this process when that one ends, for any reason.

    The main process never waits for a camera that is at work: messages are taken at once.
    """
    parent = multiprocessing.parent_process()
    assert parent is not None
    while True:
        if parent.sentinel in wait([pipe, parent.sentinel]):
            os._exit(1)
        try:
            inbox.put(msgspec.msgpack.decode(pipe.recv_bytes(), type=Go))
        except (EOFError, OSError):
            os._exit(1)
