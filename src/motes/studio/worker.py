"""A worker process: it does one task after the other, on one film."""

from __future__ import annotations

import contextlib
import ctypes
import gc
import os
import time
from multiprocessing.connection import Connection
from typing import Any

from motes.core.import_callable import explain
from motes.core.system import system
from motes.studio.workplace import Done, Failed, StoppedError, Workplace
from motes.video.film import DamagedError

NICENESS = 10
"""Of work in the background, so that pictures and the server come first."""
TIDY = 1.0
"""Seconds of work after which a worker gives memory back."""


def main(pipe: Connection, stop: Any, memory: int, background: bool) -> None:
    """Do tasks until the pipe is closed, with so much memory; the first one opens the film."""
    system.limit_memory(memory)
    if background:
        system.lower_priority(NICENESS)
    place = Workplace(pipe, stop)
    with contextlib.suppress(EOFError, OSError, KeyboardInterrupt):
        worked = 0.0
        while True:
            task = place.receive()
            begun = time.monotonic()
            try:
                place.send(Done(task(place)))
            except StoppedError:
                place.send(Done())
            except DamagedError as error:
                place.send(Failed(text_of(error), damaged=True))
            except Exception as error:  # a damaged film may cause any
                place.send(Failed(text_of(error)))
            del task
            worked += time.monotonic() - begun
            if worked > TIDY:
                give_back()
                worked = 0.0


def text_of(error: BaseException) -> str:
    """Return an error in one line."""
    if isinstance(error, MemoryError):
        return "This needs more memory than a worker may have; make the film or network smaller."
    return explain(error)


def give_back() -> None:
    """Give memory that is not needed any more back to the system.

    A decoder holds its pictures in circles of references, and the C library keeps what was freed:
    without this, a worker stays as large as in its longest task, and grows.
    """
    gc.collect()
    trim = getattr(ctypes.CDLL(None), "malloc_trim", None) if os.name == "posix" else None
    if trim is not None:
        trim(0)
