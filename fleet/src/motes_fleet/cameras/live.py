"""Cameras and streams that may stall, end and come back; always the newest frame is given."""

from __future__ import annotations

import threading
import time
from collections import deque
from collections.abc import Iterator
from typing import Self

from motes import Frame, MotesError, Source, SourceError, open_source
from motes.video import decoder, is_remote, pauses

ANSWER_MARGIN = 0.5
"""Seconds for which FFmpeg may be late with its report that no packet arrives."""

CATCH_UP = 2.0
"""Seconds after the opening in which old frames are dropped; later ones are used as they arrive."""
MIN_STEP = 1e-3
"""Smallest time from one frame to the next, in seconds."""
POLL_INTERVAL = 0.1
"""Seconds between two checks for a new frame or message."""

CLOCK_GAIN = 0.01
"""Fraction of the difference between the two clocks that each frame corrects."""


class Live:
    """An iterator over the newest frames of a live source, and over messages about its failures.

    A thread reads the source. While one frame is processed, each new frame replaces the one that
    waits, and the replaced frames are counted. If the source fails, there is one message, and the
    source is opened again after growing pauses. The iterator has no end, unless the source turns
    out to be a recording; see `open_source`.

    Parameters
    ----------
    source
        The source, as for `open_source`.
    opened
        The open source; None if opening it failed.
    error
        Why opening it failed.
    origin
        The reading of `time.monotonic` at time 0 of the frames; by default, now.

    Attributes
    ----------
    dropped
        Number of frames that were read but never given.
    """

    def __init__(
        self, source: str, opened: Source | None, error: str = "", origin: float | None = None
    ) -> None:
        self._address, self._source = source, opened
        self._origin = time.monotonic() if origin is None else origin
        self._changed = threading.Condition()
        self._messages: deque[str] = deque()
        self._frame: Frame | None = None
        self._count = self.dropped = 0
        self._last_stamp = self._last_arrival = self._opened = self._last_time = 0.0
        self._clock_offset: float | None = None
        self._active_at: float | None = None
        """Clock reading at the last frame or opening; None while the source is not open."""
        self._failed_at: float | None = None
        """Clock reading when the source failed; None while it works."""
        self._closed, self._ended = threading.Event(), threading.Event()
        if opened is None:
            self._report_failure(error)
        threading.Thread(target=self._read, name="live", daemon=True).start()

    def __iter__(self) -> Iterator[Frame | str]:
        while not self._closed.is_set():
            ended = self._ended.is_set()
            with self._changed:
                limit = decoder.READ_TIMEOUT + ANSWER_MARGIN
                self._changed.wait_for(
                    lambda: self._messages or self._frame is not None, POLL_INTERVAL
                )
                active_at = None if ended else self._active_at
                if active_at is not None and time.monotonic() - active_at > limit:
                    self._report_failure(f"{self._source_name} sends no pictures.")
                if self._messages:
                    item: Frame | str | None = self._messages.popleft()
                else:
                    item, self._frame = self._frame, None
            if item is not None:
                yield item
            elif ended:
                return

    @property
    def _source_name(self) -> str:
        return self._source.name if self._source is not None else self._address

    def _read(self) -> None:
        """Read the source; open it again after each failure."""
        waits = pauses()
        while not self._closed.is_set():
            try:
                if self._source is None:
                    self._source = open_source(self._address)
                with self._source:
                    self._active_at = self._last_arrival = self._opened = time.monotonic()
                    self._clock_offset = None
                    for frame in self._source:
                        self._keep(frame)
                        waits = pauses()
                        if self._closed.is_set():
                            return
                self._ended.set()
                return
            except MotesError as error:
                reason = str(error)
            self._source = None
            with self._changed:
                self._active_at = None
                self._report_failure(reason)
            self._closed.wait(next(waits))

    def _keep(self, frame: Frame) -> None:
        """Keep a frame as the newest one."""
        now = time.monotonic()
        interval, waited = frame.time - self._last_stamp, now - self._last_arrival
        self._last_stamp, self._last_arrival = frame.time, now
        if self._clock_offset is None:
            # Frames sent while the source was opened arrive all at once, and are old.
            if waited < interval / 2 and now < self._opened + CATCH_UP:
                self.dropped += 1
                return
            self._clock_offset = now - frame.time
        # The times are those of the source, since frames may arrive in bursts.
        self._clock_offset += CLOCK_GAIN * (now - frame.time - self._clock_offset)
        moment = max(self._last_time + MIN_STEP, frame.time + self._clock_offset - self._origin)
        with self._changed:
            self._last_time = moment
            if self._failed_at is not None:
                name, seconds = self._source_name, now - self._failed_at
                self._messages.append(f"{name} is back after {seconds:.1f} s.")
            self._active_at, self._failed_at = now, None
            self.dropped += self._frame is not None
            self._frame = Frame(self._count, moment, frame.pixels)
            self._count += 1
            self._changed.notify()

    def _report_failure(self, reason: str) -> None:
        """Add a message about a failure, unless there was one since the last frame."""
        if self._failed_at is None:
            self._failed_at = time.monotonic()
            self._messages.append(f"{reason} It is tried again, with growing pauses.")

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self._closed.set()


def open_watched(
    source: str, origin: float | None = None, fps: float | None = None
) -> Source | Live:
    """Open a source of frames: a recording as `Source`, a live source as `Live`.

    Raises
    ------
    SourceError
        If a file or folder cannot be read; a camera or an address is tried again instead.
    """
    try:
        opened = open_source(source, fps=fps)
    except SourceError as error:
        if not is_remote(source):
            raise
        return Live(source, None, str(error), origin)
    return Live(source, opened, origin=origin) if opened.live else opened
