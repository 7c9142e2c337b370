"""Pipes, read so that waiting for their writer can be ended."""

from __future__ import annotations

import io
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from typing import TypeVar

from motes.core.interrupts import deferred

T = TypeVar("T")
GLANCE = 0.1
"""Seconds between looks whether the waiting shall end."""


class Pipe(io.FileIO):
    """A pipe, FIFO or terminal, as a file for PyAV; `stop` is its end, however long it is silent.

    FFmpeg itself would wait in a call of the system that nothing ends, and a limit of time would
    end a slow writer. What reads it runs in a thread of its own: signals come to the main thread,
    and FFmpeg passes no interrupt on. Opening a FIFO waits for its writer.
    """

    def __init__(self, path: str) -> None:
        super().__init__(path)
        self._stopped = False

    def read(self, size: int | None = -1, /) -> bytes:
        """Wait for bytes, and return those that are there; none at the end."""
        from multiprocessing.connection import wait  # takes 1.5 MB, which films do without

        while not self._stopped:
            if wait([self.fileno()], GLANCE):
                return super().read(size)
        return b""

    def stop(self) -> None:
        """End the waiting; any thread may call this."""
        self._stopped = True

    def in_thread(self, task: Callable[[], T]) -> T:
        """Return the result of a task that reads the pipe; an interrupt stops it."""
        with ThreadPoolExecutor(1) as thread:
            try:
                with deferred():
                    result = thread.submit(task)
                return result.result()
            except BaseException:
                self.stop()
                raise
