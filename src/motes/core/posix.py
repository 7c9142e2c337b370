"""What motes asks of Linux and macOS; `motes.core.windows` has the same functions."""

from __future__ import annotations

import contextlib
import fcntl
import os
import resource
import signal
import sys
from collections.abc import Iterator, Sequence
from typing import BinaryIO

assert sys.platform != "win32"  # so that types are checked for each system


@contextlib.contextmanager
def blocked_signals(numbers: Sequence[int]) -> Iterator[None]:
    """Block signals; a process that is started meanwhile never receives them."""
    from multiprocessing import resource_tracker  # slow to import, and seldom needed

    mask = signal.pthread_sigmask(signal.SIG_BLOCK, numbers)
    try:
        resource_tracker.ensure_running()  # every process starts it first, and it unblocks signals
        signal.pthread_sigmask(signal.SIG_BLOCK, numbers)
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, mask)


def lock(file: BinaryIO) -> None:
    """Lock a file until it is closed; raise an OSError if another program has locked it."""
    fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)


def begin_group() -> None:
    """Let this process and all that it starts be one group."""
    os.setpgid(0, 0)


def end_group(leader: int) -> None:
    """End a process that has begun a group, and all that it has started, at once."""
    with contextlib.suppress(ProcessLookupError):
        os.killpg(leader, signal.SIGKILL)


def limits() -> tuple[float, float]:
    """Return how many bytes of addresses and how many open files this process may have."""
    found = (resource.getrlimit(each)[0] for each in (resource.RLIMIT_AS, resource.RLIMIT_NOFILE))
    addresses, files = (float("inf") if n == resource.RLIM_INFINITY else n for n in found)
    return addresses, files
