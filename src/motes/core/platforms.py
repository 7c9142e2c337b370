"""What motes asks of the operating system, beyond what Python has for all of them."""

from __future__ import annotations

import contextlib
import os
import signal
import sys
from collections.abc import Iterator
from typing import BinaryIO

from motes.core.interrupts import SIGNALS

if sys.platform == "win32":
    import ctypes
    import msvcrt
    import subprocess

    @contextlib.contextmanager
    def blocked_signals() -> Iterator[None]:
        """Ignore Ctrl-C; a process that is started meanwhile never receives it."""
        ctypes.windll.kernel32.SetConsoleCtrlHandler(None, True)
        try:
            yield
        finally:
            ctypes.windll.kernel32.SetConsoleCtrlHandler(None, False)

    def lock(file: BinaryIO) -> None:
        """Lock a file until it is closed; raise an OSError if another program has locked it."""
        msvcrt.locking(file.fileno(), msvcrt.LK_NBLCK, 1)

    def begin_group() -> None:
        """Do nothing: Windows knows what a process has started."""

    def end_group(leader: int) -> None:
        """End a process and all that it has started, at once."""
        command = "taskkill", "/F", "/T", "/PID", str(leader)
        subprocess.run(command, capture_output=True, check=False)

    def limits() -> tuple[float, float]:
        """Return that Windows limits neither addresses nor open files."""
        return float("inf"), float("inf")

else:
    import fcntl
    import resource

    @contextlib.contextmanager
    def blocked_signals() -> Iterator[None]:
        """Block signals that ask to end; a process started meanwhile never receives them."""
        from multiprocessing import resource_tracker  # slow to import, and seldom needed

        mask = signal.pthread_sigmask(signal.SIG_BLOCK, SIGNALS)
        try:
            resource_tracker.ensure_running()  # every process starts it, and it unblocks signals
            signal.pthread_sigmask(signal.SIG_BLOCK, SIGNALS)
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
        """Return how many bytes of addresses and open files this process may have."""
        kinds = resource.RLIMIT_AS, resource.RLIMIT_NOFILE
        found = (resource.getrlimit(each)[0] for each in kinds)
        addresses, files = (float("inf") if n == resource.RLIM_INFINITY else n for n in found)
        return addresses, files
