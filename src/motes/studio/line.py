"""The line between a worker and the server: answers go out, tasks and wishes come in."""

from __future__ import annotations

import time
from multiprocessing.connection import Connection
from typing import Any

import msgspec

from motes.studio.tasks import PAUSE, STOP, Alive, Answer, Task

WAIT = 0.05
"""Seconds between looks of a paused worker."""


class StoppedError(Exception):
    """The server wants the task to end."""


class WorkerLine:
    """A worker's line to the server.

    Parameters
    ----------
    pipe
        Of messages.
    wish
        `RUN`, `PAUSE` or `STOP`, in shared memory.
    """

    def __init__(self, pipe: Connection, wish: Any) -> None:
        self._pipe, self._wish = pipe, wish
        self._sent = 0.0

    def send(self, answer: Answer) -> None:
        """Send an answer."""
        self._pipe.send_bytes(msgspec.msgpack.encode(answer))
        self._sent = time.monotonic()

    def receive(self) -> Task:
        """Wait for the next task."""
        task: Task = msgspec.msgpack.decode(self._pipe.recv_bytes(), type=Task)
        return task

    def check(self, done: int = 0) -> None:
        """Give a sign of life each second, wait while paused, raise `StoppedError` if wanted."""
        if time.monotonic() - self._sent > 1:
            self.send(Alive(done))
        while self._wish.value == PAUSE:
            time.sleep(WAIT)
            if time.monotonic() - self._sent > 1:
                self.send(Alive(done))
        if self._wish.value == STOP:
            raise StoppedError
