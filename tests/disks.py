"""A disk that is full, for tests that need no such disk and no right to make one."""

import errno
import os
from typing import BinaryIO

import pytest

from motes.core import files
from motes.core.files import PartialFile


def fill_after(monkeypatch: pytest.MonkeyPatch, count: int) -> None:
    """Let the disk be full after some files of a folder, inside of the next one."""
    put, written = files.write_all, list[str]()

    def full(file: BinaryIO, data: bytes | memoryview) -> None:
        written.append(file.name)
        if len(written) > count:
            put(file, data[:1])
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
        put(file, data)

    monkeypatch.setattr(files, "write_all", full)


def fill(monkeypatch: pytest.MonkeyPatch, target: str, room: int = 0) -> None:
    """Let the disk be full for the partial files of a target, one byte after `room`."""
    put = PartialFile._put

    def full(self: PartialFile, place: int, data: bytes | memoryview) -> None:
        if self.path.name.startswith(f"{target}.partial-") and place + len(data) > room:
            put(self, place, data[:1])
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
        put(self, place, data)

    monkeypatch.setattr(PartialFile, "_put", full)
