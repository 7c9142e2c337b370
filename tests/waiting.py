"""What tests wait for: something that becomes so, a process that ends."""

import inspect
import time
from collections.abc import Callable
from pathlib import Path

PATIENCE = 120.0
"""Seconds after which a test gives up: ten times what anything takes where one other process is
busy, so that a machine with ten of them is no failure."""


def source(holds: Callable[[], object]) -> str:
    """Return the line in which a condition stands, for who waits for it in vain."""
    return " ".join(inspect.getsource(holds).split())


def wait_until(holds: Callable[[], object]) -> None:
    end = time.monotonic() + PATIENCE
    while not holds():
        assert time.monotonic() < end, f"waited {PATIENCE:g} s in vain: {source(holds)}"
        time.sleep(0.01)


def runs(pid: int) -> bool:
    """Return whether a process is there, and has not ended."""
    try:
        return Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[0] != "Z"
    except (FileNotFoundError, ProcessLookupError):
        return False
