"""A live source that is opened again after its connection drops."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable, Generator, Iterator

from motes.core.errors import AwayError, SourceError
from motes.video.decoder import Decoder
from motes.video.report import Reader, Report, Stamped

FIRST_PAUSE, LONGEST_PAUSE = 0.5, 30.0
"""Seconds before what failed is tried again."""

RETRY_NOTE = "It is tried again, with growing pauses."


def pauses(first: float = FIRST_PAUSE) -> Iterator[float]:
    """Yield the seconds to wait before each new try, each time twice as many, up to the longest."""
    while True:
        yield first
        first = min(2 * first, LONGEST_PAUSE)


class Persistent(Reader):
    """The pictures of a live source over all its connections, with times that keep increasing.

    Raises a SourceError while reading: if a source that turns out to be a recording ends in an
    error, or a live one stays away for longer than the patience. `decoder` is the source, opened
    for the first time, and `connect` opens it again. `on_drop` is called with one line of text when
    it drops, and when it is back; `patience` is for how many seconds it is tried again, None
    without end.
    """

    live = True

    def __init__(
        self,
        connect: Callable[[], Decoder],
        decoder: Decoder,
        name: str,
        on_drop: Callable[[str], None],
        patience: float | None,
    ) -> None:
        self._connect, self._decoder, self._name, self._on_drop = connect, decoder, name, on_drop
        self._patience = float("inf") if patience is None else patience
        self._stopped = threading.Event()
        self._pauses = pauses()
        self.fps = decoder.fps

    @property
    def realtime(self) -> bool:
        """Whether pictures certainly arrive in real time."""
        return self._decoder.realtime

    def pictures(self, report: Report) -> Generator[Stamped, None, None]:
        """Yield the pictures of all connections in turn; a recording has only one connection."""
        time_reached, last_arrival = 0.0, time.monotonic()
        dropped_at: float | None = None
        while True:
            origin: float | None = None
            try:
                for stamp, load in self._decoder.pictures(report):
                    now = time.monotonic()
                    self._pauses = pauses()
                    if dropped_at is not None:
                        self._on_drop(f"{self._name} is back after {now - dropped_at:.1f} s.")
                        dropped_at = None
                    if stamp is None:
                        yield None, load
                    else:
                        if origin is None:
                            passed = time_reached + now - last_arrival if report.drops else 0.0
                            origin = stamp - passed
                        time_reached = stamp - origin
                        yield time_reached, load
                    last_arrival = time.monotonic()
            except SourceError as error:
                if self._decoder.recorded:
                    raise
                report.drops += 1
                if dropped_at is None:
                    dropped_at = time.monotonic()
                    self._on_drop(f"{error} {RETRY_NOTE}")
                self._decoder.close()
            else:
                return
            if not self._open_again(dropped_at):
                return

    def _open_again(self, dropped_at: float) -> bool:
        """Wait until the source answers; return False if the waiting was stopped before."""
        until = dropped_at + self._patience
        for pause in self._pauses:
            if self._stopped.wait(min(pause, max(0.0, until - time.monotonic()))):
                break
            if time.monotonic() >= until:
                raise AwayError(
                    f"{self._name} has not come back for {self._patience:g} s; check it, or wait "
                    f"longer with --reconnect."
                )
            try:
                self._decoder = self._connect()
            except SourceError:
                continue
            return True
        return False

    def stop(self) -> None:
        """End the waiting; any thread may call this."""
        self._stopped.set()

    def close(self) -> None:
        """Close the connection."""
        self.stop()
        self._decoder.close()
