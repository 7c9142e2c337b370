"""What is computed before it is asked for, in a thread, and handed over in its order."""

from __future__ import annotations

import contextlib
import queue
import threading
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from typing import TypeVar

from motes.core.interrupts import deferred

T = TypeVar("T")
AHEAD = 4
"""So many frames are decoded before they are asked for; more would only need more memory."""


@contextlib.contextmanager
def prefetch(items: Iterable[T], ahead: int = AHEAD) -> Iterator[Iterator[T]]:
    """Iterate over items that a thread gets ahead of time: decoding and tracking overlap.

    What the thread raises is raised by the iterator, after the items before. When the context
    ends, so have the thread and the iterator, also for another thread that waits for an item.
    """
    ready: queue.Queue[T | _End] = queue.Queue(ahead)
    stopped = threading.Event()

    def get() -> None:
        error: BaseException | None = None
        try:
            for item in items:
                ready.put(item)
                if stopped.is_set():
                    return
        except BaseException as raised:
            error = raised
        ready.put(_End(error))

    def hand_over() -> Iterator[T]:
        while not isinstance(item := ready.get(), _End):
            yield item
        if item.error is not None:
            raise item.error

    thread = threading.Thread(target=get, name="prefetch", daemon=True)
    try:
        with deferred():  # else an interrupt may leave a thread behind that nobody ends
            thread.start()
        yield hand_over()
    finally:
        with deferred():
            stopped.set()
            while thread.is_alive():  # make room, in case it waits to hand over
                with contextlib.suppress(queue.Empty):
                    ready.get(timeout=0.01)
            while not ready.empty():
                ready.get()
            ready.put(_End(None))


@dataclass(frozen=True, slots=True)
class _End:
    error: BaseException | None
