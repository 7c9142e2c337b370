"""A disk that is full, for tests that need no such disk and no right to make one."""

from __future__ import annotations

import errno
import os

import pytest

from motes.core.files import PartialFile


def fill(monkeypatch: pytest.MonkeyPatch, target: str) -> None:
    """Let the disk be full for the partial files of a target, after their first byte."""
    put = PartialFile._put

    def full(self: PartialFile, place: int, data: bytes | memoryview) -> None:
        if self.path.name.startswith(f"{target}.partial-"):
            put(self, place, data[:1])
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
        put(self, place, data)

    monkeypatch.setattr(PartialFile, "_put", full)
