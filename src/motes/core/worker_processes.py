"""Worker processes: they receive no signal that asks to end, and end with this process."""

from __future__ import annotations

import multiprocessing
import signal
from collections.abc import Callable
from contextlib import AbstractContextManager
from multiprocessing.connection import Connection
from multiprocessing.context import BaseContext
from multiprocessing.process import BaseProcess
from typing import Any

from motes.core.interrupts import SIGNALS
from motes.core.system import system


def blocked_signals() -> AbstractContextManager[None]:
    """Block signals that ask to end; a process that is started meanwhile never receives them."""
    return system.blocked_signals(SIGNALS)


def started(
    serve: Callable[..., None],
    *arguments: Any,
    context: BaseContext | None = None,
    daemon: bool = True,
) -> tuple[BaseProcess, Connection]:
    """Start a process that calls a function with its end of a pipe; return it, and the other end.

    The function is at the top level of a module, and also gets the arguments. `context` is how the
    process is started, by default as a new interpreter. A `daemon` may start no processes itself.
    """
    made: Any = context or multiprocessing.get_context("spawn")
    with blocked_signals():
        ours, theirs = made.Pipe()
        process = made.Process(target=serve, args=(theirs, *arguments), daemon=daemon)
        process.start()
        theirs.close()
    return process, ours


def cause(code: int | None) -> str:
    """Return in words how a process ended."""
    if code is None or code >= 0:
        return f"exit code {code}"
    name = signal.Signals(-code).name
    return f"{name} (was there too little memory?)" if name == "SIGKILL" else name
