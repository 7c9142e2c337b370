"""The process of a camera: `CameraProcess` in the main process, `_serve` in its own."""

from __future__ import annotations

import os
import queue
import threading
from collections.abc import Iterator, Sequence
from contextlib import suppress
from multiprocessing.connection import Connection

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

    def _lost(self) -> Iterator[CameraMessage | CameraEnded]:
        self.process.join()
        yield from self.fail(f"its process ended with {cause(self.process.exitcode)}")

    def close(self) -> None:
        """End the process."""
        self.process.kill()
        self.process.join()
        if self.pipe is not None:
            self.pipe.close()


class PipeLine:
    """The line from a camera's process to the main process; it ends this one with that one."""

    def __init__(self, pipe: Connection) -> None:
        self._pipe = pipe
        self._inbox: queue.SimpleQueue[Go] = queue.SimpleQueue()
        threading.Thread(target=_receive, args=(pipe, self._inbox), daemon=True).start()

    def send(self, message: Message) -> None:
        """Send a message; wait while the pipe is full."""
        self._pipe.send_bytes(msgspec.msgpack.encode(message))

    def go(self) -> Go:
        """Wait for the `Go` of a recording's frame."""
        return self._inbox.get()

    def arrivals(self) -> Sequence[Arrival]:
        """Return what has come since the last call."""
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
        watch_camera(camera, seed, origin, target, PipeLine(pipe))


def _receive(pipe: Connection, inbox: queue.SimpleQueue[Go]) -> None:
    """Receive what the main process sends; end this process when that one ends, for any reason.

    The main process never waits for a camera that is at work: messages are taken at once.
    """
    while True:
        try:
            inbox.put(msgspec.msgpack.decode(pipe.recv_bytes(), type=Go))
        except (EOFError, OSError):
            os._exit(1)
