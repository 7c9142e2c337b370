"""Worker processes: they receive no signal that asks to end, and end with this process."""

from __future__ import annotations

import contextlib
import signal
from collections.abc import Iterator
from multiprocessing import resource_tracker

from motes.core.interrupts import SIGNALS


@contextlib.contextmanager
def blocked_signals() -> Iterator[None]:
    """Block signals that ask to end; a process that is started meanwhile never receives them."""
    mask = signal.pthread_sigmask(signal.SIG_BLOCK, SIGNALS)
    try:
        resource_tracker.ensure_running()  # every process starts it first, and it unblocks signals
        signal.pthread_sigmask(signal.SIG_BLOCK, SIGNALS)
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, mask)


def cause(code: int | None) -> str:
    """Return in words how a process ended."""
    if code is None or code >= 0:
        return f"exit code {code}"
    name = signal.Signals(-code).name
    return f"{name} (was there too little memory?)" if name == "SIGKILL" else name
