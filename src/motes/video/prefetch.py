"""Items that a thread computes in advance and that are given in their order."""

from __future__ import annotations

import os
import threading
from collections import deque
from collections.abc import Iterable, Iterator
from contextlib import AbstractContextManager, nullcontext
from typing import Generic, Self, TypeVar

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


class Prefetch(Generic[T]):
    """An iterator of items that a thread gets in advance, and a context manager that ends it.

    An error raised in the thread is raised by the iterator after the items before it. When the
    context ends, the thread has ended, and so has the iterator, even in another thread that waits
    for an item. At most `ahead` items wait to be used.

    A child of `fork` has no such thread: the iterator raises a SourceError there.
    """

    def __init__(self, items: Iterable[T], ahead: int) -> None:
        self._items, self._ahead, self._owner = items, ahead, os.getpid()
        self._changed = threading.Condition()
        self._ready: deque[T] = deque()
        self._ended = self._stopped = False
        self._error: BaseException | None = None
        self._thread = threading.Thread(target=self._read, name="prefetch", daemon=True)

    @property
    def _full(self) -> bool:
        """Whether the thread waits before it adds an item."""
        return len(self._ready) >= self._ahead

    def _leave_out(self) -> None:
        """Leave out items that are not wanted any more."""

    def _read(self) -> None:
        error: BaseException | None = None
        try:
            for item in self._items:
                with self._changed:
                    while self._full and not self._stopped:
                        self._changed.wait()
                    if self._stopped:
                        return
                    self._ready.append(item)
                    self._leave_out()
                    self._changed.notify_all()
        except BaseException as raised:
            error = raised
        finally:
            with self._changed:
                self._ended, self._error = True, error
                self._changed.notify_all()

    def __iter__(self) -> Self:
        return self

    def __next__(self) -> T:
        check_reader(self._owner)
        with self._changed:
            while not (self._ready or self._ended or self._stopped):
                self._changed.wait()
            if self._ready:
                self._leave_out()
                self._changed.notify_all()
                return self._ready.popleft()
            error, self._error = self._error, None
        raise error or StopIteration

    def __enter__(self) -> Self:
        try:
            with deferred():  # an interrupt comes when the thread runs, and ends it
                self._thread.start()
        except BaseException:
            self.__exit__()
            raise
        return self

    def __exit__(self, *_: object) -> None:
        if os.getpid() != self._owner:  # in a child the lock may be held for ever
            return
        with deferred():
            with self._changed:
                self._stopped = True
                self._changed.notify_all()
            self._thread.join()
            self._ready.clear()
            self._error = None


def prefetch(items: Iterable[T], ahead: int = QUEUE_SIZE) -> AbstractContextManager[Iterator[T]]:
    """Iterate over items that a thread gets in advance: decoding and tracking overlap.

    With MOTES_THREADS=1 there is no such thread: a worker of a batch has one core, and others use
    the rest of the machine.
    """
    if os.environ.get("MOTES_THREADS") == "1":
        return nullcontext(iter(items))
    return Prefetch(items, ahead)
