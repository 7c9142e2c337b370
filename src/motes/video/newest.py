"""The newest frames of a live source: frames that have waited for too long are left out."""

from __future__ import annotations

import threading
import time
from collections import deque
from collections.abc import Iterator
from typing import Self

from motes.core.frame import Frame
from motes.core.interrupts import deferred
from motes.video.sources import Source

LONGEST_WAIT = 0.1
"""Seconds that a frame may wait while there is a newer one.

Frames come in small bursts over a network. People take a delay up to this as none (Miller, Response
time in man-computer conversational transactions, 1968).
"""


class Newest:
    """An iterator of frames that a thread reads, and a context manager that ends the thread.

    While the source is in real time (`Source.realtime`), frames that have waited for
    `LONGEST_WAIT` are left out if there is a newer one, and counted in `Report.late`. So results
    are late by this and the time of their computing at most. Otherwise the thread waits until each
    frame is used.

    An error of the source is raised after the frames before it. Stop the source before the context
    ends, if it may wait.
    """

    def __init__(self, film: Source) -> None:
        self._film = film
        self._changed = threading.Condition()
        self._frames: deque[Frame] = deque()
        self._ended = self._stopped = False
        self._error: BaseException | None = None
        self._thread = threading.Thread(target=self._read, name="newest", daemon=True)

    def _read(self) -> None:
        error: BaseException | None = None
        try:
            for frame in self._film:
                with self._changed:
                    while self._frames and not (self._stopped or self._film.realtime):
                        self._changed.wait()
                    if self._stopped:
                        return
                    self._frames.append(frame)
                    self._leave_out()
                    self._changed.notify_all()
        except BaseException as raised:
            error = raised
        finally:
            with self._changed:
                self._ended, self._error = True, error
                self._changed.notify_all()

    def _leave_out(self) -> None:
        """Leave out frames that have waited for too long, but not the newest one."""
        limit = time.monotonic() - LONGEST_WAIT
        while self._film.realtime and len(self._frames) > 1:
            if (self._frames[0].arrived or limit) >= limit:
                return
            self._frames.popleft()
            self._film.report.late += 1

    def __iter__(self) -> Iterator[Frame]:
        while True:
            with self._changed:
                while not (self._frames or self._ended or self._stopped):
                    self._changed.wait()
                if self._stopped or not self._frames:
                    break
                self._leave_out()
                frame = self._frames.popleft()
                self._changed.notify_all()
            yield frame
        if self._error is not None and not self._stopped:
            raise self._error

    def __enter__(self) -> Self:
        with deferred():  # otherwise an interrupt may leave a thread behind that never ends
            self._thread.start()
        return self

    def __exit__(self, *_: object) -> None:
        with deferred():
            with self._changed:
                self._stopped = True
                self._changed.notify_all()
            self._thread.join()
