"""A live source that is opened again where it drops."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable, Generator

from motes.core.errors import SourceError
from motes.video.decoder import Decoder, Report, Stamped

FIRST_PAUSE, LONGEST_PAUSE = 0.5, 30.0
"""Seconds until a source that failed is opened again; each pause is twice the one before."""

AGAIN = "It is tried again, with growing pauses."


class Persistent:
    """The pictures of a live source over all its connections, with times that go on.

    Parameters
    ----------
    connect
        Opens the source.
    film
        The source, opened for the first time.
    name
        What it is called in messages.
    on_drop
        Called with a line when it drops, and when it is back.

    Raises
    ------
    SourceError
        While reading: if a source that turns out to be a recording ends in an error.
    """

    duration: float | None = None
    count: int | None = None
    live = True

    def __init__(
        self,
        connect: Callable[[], Decoder],
        film: Decoder,
        name: str,
        on_drop: Callable[[str], None],
    ) -> None:
        self._connect, self._film, self._name, self._on_drop = connect, film, name, on_drop
        self._stopped = threading.Event()
        self._pause = FIRST_PAUSE
        self.fps = film.fps

    def pictures(self, report: Report) -> Generator[Stamped, None, None]:
        """Yield the pictures of one connection after the other; a recording has only one."""
        moment, came = 0.0, time.monotonic()
        lost: float | None = None
        while True:
            first: float | None = None
            try:
                for stamp, load in self._film.pictures(report):
                    now = time.monotonic()
                    self._pause = FIRST_PAUSE
                    if lost is not None:
                        self._on_drop(f"{self._name} is back after {now - lost:.1f} s.")
                        lost = None
                    if stamp is None:
                        yield None, load
                    else:
                        if first is None:
                            first = stamp - (moment + now - came if report.drops else 0.0)
                        moment = stamp - first
                        yield moment, load
                    came = time.monotonic()
            except SourceError as error:
                if self._film.recorded:
                    raise
                report.drops += 1
                if lost is None:
                    lost = time.monotonic()
                    self._on_drop(f"{error} {AGAIN}")
                self._film.close()
            else:
                return
            if not self._open_again():
                return

    def _open_again(self) -> bool:
        """Wait for the source to answer; return whether it does, not having been stopped."""
        while not self._stopped.wait(self._pause):
            self._pause = min(2 * self._pause, LONGEST_PAUSE)
            try:
                self._film = self._connect()
            except SourceError:
                continue
            return True
        return False

    def file_of(self, index: int) -> str | None:
        """Return None: pictures of a live source are in no file."""
        return None

    def stop(self) -> None:
        """End the waiting, from any thread."""
        self._stopped.set()

    def close(self) -> None:
        """Let go of the connection."""
        self.stop()
        self._film.close()
