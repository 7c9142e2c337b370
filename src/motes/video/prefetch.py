"""Items that a thread computes in advance and that are given in their order."""

from __future__ import annotations

import contextlib
import os
import queue
import threading
from collections.abc import Iterable, Iterator
from typing import TypeVar

from motes.core.errors import SourceError
from motes.core.interrupts import deferred

T = TypeVar("T")
QUEUE_SIZE = 2
"""Frames that are decoded in advance; more would only need more memory."""


def check_reader(owner: int) -> None:
    """Raise a SourceError if this is not the process `owner`, which has begun to read frames."""
    if os.getpid() != owner:
        raise SourceError(
            "These frames are read by another process, of which this one is a child; open the "
            "source anew in each."
        )


@contextlib.contextmanager
def prefetch(items: Iterable[T], ahead: int = QUEUE_SIZE) -> Iterator[Iterator[T]]:
    """Iterate over items that a thread gets in advance: decoding and tracking overlap.

    An error raised in the thread is raised by the iterator after the items before it. When the
    context ends, the thread has ended, and so has the iterator, even in another thread that waits
    for an item.

    A child of `fork` has no such thread: the iterator raises a SourceError there.

    With MOTES_THREADS=1 there is no such thread: a worker of a batch has one core, and others use
    the rest of the machine. At most `ahead` items wait to be used.
    """
    if os.environ.get("MOTES_THREADS") == "1":
        yield iter(items)
        return
    # Items, each in a tuple; last the error that has ended them, or None.
    ready: queue.Queue[tuple[T] | BaseException | None] = queue.Queue(ahead)
    stopped, owner = threading.Event(), os.getpid()

    def produce() -> None:
        error: BaseException | None = None
        try:
            for item in items:
                ready.put((item,))
                if stopped.is_set():
                    return
        except BaseException as raised:
            error = raised
        ready.put(error)

    def items_in_order() -> Iterator[T]:
        while True:
            check_reader(owner)
            if not isinstance(got := ready.get(), tuple):
                break
            yield got[0]
        if got is not None:
            raise got

    thread = threading.Thread(target=produce, name="prefetch", daemon=True)
    try:
        with deferred():  # otherwise an interrupt may leave a thread behind that never ends
            thread.start()
        yield items_in_order()
    finally:
        if os.getpid() == owner:  # in a child the queue may be locked for ever
            with deferred():
                stopped.set()
                while thread.is_alive():  # make room, in case the thread waits to put an item
                    with contextlib.suppress(queue.Empty):
                        ready.get(timeout=0.01)
                while not ready.empty():
                    ready.get()
                ready.put(None)
