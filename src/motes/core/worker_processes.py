"""Worker processes: they receive no signal that asks to end, and end with this process."""

from __future__ import annotations

import signal
from contextlib import AbstractContextManager

from motes.core.interrupts import SIGNALS
from motes.core.system import system


def blocked_signals() -> AbstractContextManager[None]:
    """Block signals that ask to end; a process that is started meanwhile never receives them."""
    return system.blocked_signals(SIGNALS)


def cause(code: int | None) -> str:
    """Return in words how a process ended."""
    if code is None or code >= 0:
        return f"exit code {code}"
    name = signal.Signals(-code).name
    return f"{name} (was there too little memory?)" if name == "SIGKILL" else name
