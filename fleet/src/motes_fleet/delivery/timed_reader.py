"""What a socket receives in a limited time.

A timeout of a socket limits each read alone: a peer that sends a byte now and then is never late.
"""

from __future__ import annotations

import io
import socket
import time
from typing import Any


class TooLargeError(OSError):
    """A peer sends more than it may."""


class TimedReader(io.RawIOBase):
    """Reads from a socket; raises a TimeoutError or a TooLargeError beyond its limits.

    Parameters
    ----------
    connected
        The socket. Its timeout is changed.
    seconds
        The time for all reads together.
    most
        The number of bytes of all reads together.
    """

    def __init__(self, connected: socket.socket, seconds: float, most: int) -> None:
        self._socket, self._until, self._left = connected, time.monotonic() + seconds, most
        self._file = connected.makefile("rb", buffering=0)

    def readable(self) -> bool:
        """Return True."""
        return True

    def readinto(self, buffer: Any, /) -> int | None:
        """Read what is there, or wait for it."""
        seconds = self._until - time.monotonic()
        if seconds <= 0:
            raise TimeoutError
        self._socket.settimeout(seconds)
        count = self._file.readinto(buffer)
        self._left -= count or 0
        if self._left < 0:
            raise TooLargeError
        return count

    def close(self) -> None:
        """Let go of the socket."""
        self._file.close()
        super().close()
