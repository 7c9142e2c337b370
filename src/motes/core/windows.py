"""What motes asks of Windows; `motes.core.posix` has the same functions."""

from __future__ import annotations

import contextlib
import ctypes
import msvcrt
import subprocess
import sys
from collections.abc import Iterator, Sequence
from typing import BinaryIO

assert sys.platform == "win32"  # so that types are checked for each system


@contextlib.contextmanager
def blocked_signals(_: Sequence[int]) -> Iterator[None]:
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
