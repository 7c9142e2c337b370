"""Cameras and streams that may stall, end and come back: always the newest frame."""

from __future__ import annotations

import threading
import time
from collections import deque
from collections.abc import Iterator
from typing import Self

from motes.core.errors import MotesError, SourceError
from motes.core.frame import Frame
from motes.video import decoder
from motes.video.reconnect import AGAIN, FIRST_PAUSE, LONGEST_PAUSE
from motes.video.sources import Source, is_remote, open_source

GRACE = 0.5
"""Seconds for which FFmpeg may be late to say that nothing comes."""

CATCH_UP = 2.0
"""Seconds for which a source may send what is old before it is taken as it comes."""
TICK = 1e-3
"""Least seconds from one frame to the next."""
LOOK = 0.1
"""Seconds between two looks whether anything comes."""

DRIFT = 0.01
"""Share by which the source's clock is set anew with every frame."""


class Live:
    """An iterator over the newest frames of a live source, and over its troubles.

    A thread reads. Frames that come while the last one is still being worked on take each other's
    place, and those that had to go are counted. Where the source fails, that is said once, in
    words, and it is opened again after growing pauses. It has no end, unless the source turns out
    to be a recording; see `open_source`.

    Parameters
    ----------
    source
        As `open_source` takes it.
    film
        The source if it is open already; None if that failed.
    trouble
        Why it failed.
    origin
        What `time.monotonic` said at time 0 of the frames; by default, now.

    Attributes
    ----------
    dropped
        Number of frames that were never asked for.
    """

    def __init__(
        self, source: str, film: Source | None, trouble: str = "", origin: float | None = None
    ) -> None:
        self._source, self._film = source, film
        self._origin = time.monotonic() if origin is None else origin
        self._news = threading.Condition()
        self._said: deque[str] = deque()
        self._frame: Frame | None = None
        self._count = self.dropped = 0
        self._stamp = self._last = self._opened = self._moment = 0.0
        self._base: float | None = None
        self._since: float | None = None
        """When the source last gave a frame, or was opened; None while it is not open."""
        self._trouble: float | None = None
        """Since when there is none."""
        self._closed, self._ended = threading.Event(), threading.Event()
        if film is None:
            self._fail(trouble)
        threading.Thread(target=self._read, name="live", daemon=True).start()

    def __iter__(self) -> Iterator[Frame | str]:
        while not self._closed.is_set():
            ended = self._ended.is_set()
            with self._news:
                limit = decoder.READ_TIMEOUT + GRACE
                self._news.wait_for(lambda: self._said or self._frame is not None, LOOK)
                if not ended and self._since is not None and time.monotonic() - self._since > limit:
                    self._fail(f"{self._source_name} sends no pictures.")
                if self._said:
                    news: Frame | str | None = self._said.popleft()
                else:
                    news, self._frame = self._frame, None
            if news is not None:
                yield news
            elif ended:
                return

    @property
    def _source_name(self) -> str:
        return self._film.name if self._film is not None else self._source

    def _read(self) -> None:
        """Read the source, again and again."""
        pause = FIRST_PAUSE
        while not self._closed.is_set():
            try:
                if self._film is None:
                    self._film = open_source(self._source)
                with self._film:
                    self._since = self._last = self._opened = time.monotonic()
                    self._base = None
                    for frame in self._film:
                        self._put(frame)
                        pause = FIRST_PAUSE
                        if self._closed.is_set():
                            return
                self._ended.set()
                return
            except MotesError as error:
                why = str(error)
            self._film = None
            with self._news:
                self._since = None
                self._fail(why)
            self._closed.wait(pause)
            pause = min(2 * pause, LONGEST_PAUSE)

    def _put(self, frame: Frame) -> None:
        """Make a frame the newest."""
        now = time.monotonic()
        interval, since, self._last = frame.time - self._stamp, now - self._last, now
        self._stamp = frame.time
        if self._base is None:
            # What was sent while the source was opened comes all at once, and is old.
            if since < interval / 2 and now < self._opened + CATCH_UP:
                self.dropped += 1
                return
            self._base = now - frame.time
        # Times are the source's, as frames may come in bursts.
        self._base += DRIFT * (now - frame.time - self._base)
        moment = max(self._moment + TICK, frame.time + self._base - self._origin)
        with self._news:
            self._moment = moment
            if self._trouble is not None:
                name, away = self._source_name, now - self._trouble
                self._said.append(f"{name} is back after {away:.1f} s.")
            self._since, self._trouble = now, None
            self.dropped += self._frame is not None
            self._frame = Frame(self._count, moment, frame.pixels)
            self._count += 1
            self._news.notify()

    def _fail(self, why: str) -> None:
        """Say what is wrong, unless that is known."""
        if self._trouble is None:
            self._trouble = time.monotonic()
            self._said.append(f"{why} {AGAIN}")

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self._closed.set()


def open_watched(source: str, origin: float | None = None) -> Source | Live:
    """Open a source of frames: a recording as it is, anything live as `Live`.

    Raises
    ------
    SourceError
        If there is nothing to read and never will be: a camera or an address is tried again.
    """
    try:
        film = open_source(source)
    except SourceError as error:
        if not is_remote(source):
            raise
        return Live(source, None, str(error), origin)
    return Live(source, film, origin=origin) if film.live else film
