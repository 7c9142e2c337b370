"""Processes that work for this one: they hear of no signal that asks to end, and end with it."""

from __future__ import annotations

import contextlib
import signal
from collections.abc import Iterator
from multiprocessing import resource_tracker

from motes.core.interrupts import SIGNALS


@contextlib.contextmanager
def blocked_signals() -> Iterator[None]:
    """Let signals that ask to end wait; a process that is started here never hears of them."""
    mask = signal.pthread_sigmask(signal.SIG_BLOCK, SIGNALS)
    try:
        resource_tracker.ensure_running()  # which every process starts first: it lets signals in
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
