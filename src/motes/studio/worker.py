"""A worker process: it opens one film, and does one task after the other with it."""

from __future__ import annotations

import contextlib
import ctypes
import gc
import itertools
import os
from collections.abc import Callable
from multiprocessing.connection import Connection
from typing import Any

from motes.core.import_callable import explain
from motes.core.system import system
from motes.studio.line import StoppedError, WorkerLine
from motes.studio.safety import Limits
from motes.studio.tasks import Done, Failed, Ready, Task
from motes.video.film import DamagedError

NICENESS = 10
"""Of tracking, so that pictures and the server come first."""
SEEKS = 32
"""Pictures after which their worker gives memory back."""


def main(
    pipe: Connection, wish: Any, path: str, limits: Limits, pictures: bool, whole: bool
) -> None:
    """Work until the pipe is closed: on pictures, or on all other tasks."""
    system.limit_memory(limits.memory)
    line = WorkerLine(pipe, wish)
    with contextlib.suppress(EOFError, OSError, KeyboardInterrupt):
        try:
            do = (_pictures if pictures else _tracking)(path, limits, line, whole)
        except Exception as error:  # a damaged film may cause any
            line.send(Failed(text_of(error)))
            return
        for count in itertools.count():
            task = line.receive()
            try:
                line.send(do(task))
            except StoppedError:
                line.send(Done(stopped=True))
            except DamagedError as error:
                line.send(Failed(text_of(error), damaged=True))
            except Exception as error:  # a fault, which must not reach others
                line.send(Failed(text_of(error)))
            del task
            if not pictures or count % SEEKS == 0:
                give_back()


def _pictures(path: str, limits: Limits, line: WorkerLine, whole: bool) -> Callable[[Task], Done]:
    from motes.studio.pictures import Pictures
    from motes.studio.tasks import Picture

    opened = Pictures(path, limits, line.check, whole=whole)
    line.send(Ready(opened.facts, opened.times))

    def do(task: Task) -> Done:
        if isinstance(task, Picture):
            return Done(opened.picture(task.index, task.width))
        return Done(opened.strip(task.count, task.height))  # type: ignore[union-attr]

    return do


def _tracking(path: str, _: Limits, line: WorkerLine, whole: bool) -> Callable[[Task], Done]:
    from motes.studio.tracking import Work

    system.lower_priority(NICENESS)
    work = Work(path, line, whole=whole)
    line.send(Ready(work.facts, []))
    return work.do


def text_of(error: BaseException) -> str:
    """Return an error in one line."""
    if isinstance(error, MemoryError):
        return "The film needs more memory than a worker may have; rescale it."
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
