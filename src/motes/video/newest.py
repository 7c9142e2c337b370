"""The newest frames of a live source: frames that have waited for too long are left out."""

from __future__ import annotations

import time

from motes.core.frame import Frame
from motes.video.prefetch import Prefetch
from motes.video.sources import Source

LONGEST_WAIT = 0.1
"""Seconds that a frame may wait while there is a newer one.

Frames come in small bursts over a network. People take a delay up to this as none (Miller, Response
time in man-computer conversational transactions, 1968).
"""


class Newest(Prefetch[Frame]):
    """Frames that a thread reads, as `Prefetch`; stop the source before the end, if it may wait.

    While the source is in real time (`Source.realtime`), frames that have waited for
    `LONGEST_WAIT` are left out if there is a newer one, and counted in `Report.late`. So results
    are late by this and the time of their computing at most. Otherwise the thread waits until each
    frame is used.
    """

    def __init__(self, film: Source) -> None:
        super().__init__(film, 1)
        self._film = film

    @property
    def _full(self) -> bool:
        return super()._full and not self._film.realtime

    def _leave_out(self) -> None:
        """Leave out frames that have waited for too long, but not the newest one."""
        limit = time.monotonic() - LONGEST_WAIT
        while self._film.realtime and len(self._ready) > 1:
            if (self._ready[0].arrived or limit) >= limit:
                return
            self._ready.popleft()
            self._film.report.late += 1
