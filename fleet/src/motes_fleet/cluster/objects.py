"""Files at addresses (S3, Google's storage, HTTP, ...) through fsspec; requests are repeated.

Networks fail: a request may be refused, stall, or lose its connection, perhaps after the server has
done what it asked for. So each request has a time limit and is tried again, after growing pauses;
none of them does harm when it is done twice.
"""

from __future__ import annotations

import contextlib
import functools
import random
import tempfile
import time
from collections.abc import Callable, Iterable, Iterator
from contextlib import AbstractContextManager
from pathlib import Path
from typing import Any, TypeVar

from motes import ConfigError, FormatError, MissingDependencyError
from motes.core import optional, without_password
from motes_fleet.cluster import pool as pools

T = TypeVar("T")


class StoreError(FormatError, pools.TryAgain):
    """A server or the network failed each time; a later attempt may succeed."""


TRIES = 8
"""How often a request is sent. Where one in ten fails, one in 10^8 ends a job's attempt."""
PAUSE, LONGEST_PAUSE = 0.1, 10.0
"""Seconds before the second try; it doubles, up to the longest."""
TIMEOUT = 20
"""Seconds in which some bytes have to come."""
S3: dict[str, Any] = {
    "use_listings_cache": False,
    "config_kwargs": {
        "connect_timeout": 5,
        "read_timeout": TIMEOUT,
        "retries": {"max_attempts": 0},  # they are counted here
    },
}
OPTIONS: dict[str, dict[str, Any]] = {"s3": S3, "s3a": S3}
"""Options of fsspec's file systems."""
FINAL = (FileNotFoundError, PermissionError, IsADirectoryError, ImportError)
"""Errors that no second try mends."""


class Objects:
    """The files below an address, or the one file there; see `Folder` for the same on a disk.

    Parameters
    ----------
    address
        Such as s3://BUCKET/PREFIX.

    Raises
    ------
    ConfigError
        If its kind is not known.
    MissingDependencyError
        If fsspec, or its package for this kind, is not installed.
    """

    def __init__(self, address: str) -> None:
        self._files = _file_system(address.partition("://")[0].lower())
        self._root = str(self._files._strip_protocol(address)).rstrip("/")

    def _key(self, name: str) -> str:
        return f"{self._root}/{name}" if name else self._root

    def write(self, name: str, data: bytes | Path) -> None:
        """Make a file, or replace it.

        Raises
        ------
        FormatError
            If it cannot be written.
        """
        key = self._key(name)

        def send() -> None:
            if isinstance(data, Path):
                self._files.put_file(str(data), key)
            else:
                self._files.pipe_file(key, data)

        try:
            _repeated(send, key)
        except OSError as error:
            raise FormatError(f"{key} cannot be written: {error}; check the rights.") from None

    def read(self, names: Iterable[str]) -> dict[str, bytes]:
        """Return the content of those files that are there; they are read at the same time."""
        left = {self._key(name): name for name in names}
        found: dict[str, bytes] = {}

        def load() -> None:
            failed = None
            for key, answer in self._files.cat([*left], on_error="return").items():
                if isinstance(answer, bytes):
                    found[left.pop(key)] = answer
                elif not isinstance(answer, FileNotFoundError):
                    failed = answer
            if failed is not None:
                raise failed

        if left:
            _repeated(load, next(iter(left)))
        return found

    def lines(self, name: str) -> Iterator[bytes]:
        """Yield the lines of a file, of which a copy is made."""
        with self.scratch() as folder:
            copy = Path(folder) / "copy"
            self.fetch(copy, name)
            with copy.open("rb") as file:
                yield from file

    def names(self, folder: str) -> Iterator[str]:
        """Yield the names in a folder, without the folder's."""
        key = self._key(folder)
        try:
            found = _repeated(lambda: self._files.ls(key, detail=False), key)
        except FileNotFoundError:
            return
        for each in found:
            yield each.rstrip("/").rpartition("/")[2]

    def remove(self, name: str) -> None:
        """Remove a file, or a folder with all that is in it, if it is there."""
        key = self._key(name)

        def remove() -> None:
            if self._files.exists(key):
                self._files.rm(key, recursive=True)

        with contextlib.suppress(FileNotFoundError):
            _repeated(remove, key)

    def scratch(self) -> AbstractContextManager[str]:
        """Return a new folder on this machine."""
        return tempfile.TemporaryDirectory(prefix="motes-")

    def used_alone(self) -> AbstractContextManager[None]:
        """Do nothing: no file is ever seen in part, and there is nothing to lock."""
        return contextlib.nullcontext()

    def fetch(self, goal: Path, name: str = "") -> None:
        """Copy a file to this machine; without a name, the one at the address."""
        key = self._key(name)
        _repeated(lambda: self._files.get_file(key, str(goal)), key)

    def stamp(self) -> str:
        """Return a text that changes when the file there is written again; "" if missing."""
        try:
            info = _repeated(lambda: self._files.info(self._root), self._root)
        except FileNotFoundError:
            return ""
        marks = ("ETag", "etag", "size", "LastModified", "mtime", "updated")
        return " ".join(str(info[mark]) for mark in marks if info.get(mark) is not None)


@functools.cache
def _file_system(protocol: str) -> Any:
    """Return fsspec's file system for a kind of address."""
    fsspec = optional("fsspec", f"{protocol}:// needs fsspec", "motes-fleet[cloud]")
    try:
        return fsspec.filesystem(protocol, **OPTIONS.get(protocol, {}))
    except ValueError:
        raise ConfigError(f"{protocol}:// is no kind of address that fsspec knows.") from None
    except ImportError as error:
        raise MissingDependencyError(f"{protocol}:// needs a package: {error}.") from None


def _repeated(request: Callable[[], T], what: str) -> T:
    """Return the answer of a request that is tried again when it fails.

    Raises
    ------
    StoreError
        If it fails each time.
    """
    for tried in range(1, TRIES + 1):
        try:
            return request()
        except FINAL:
            raise
        except Exception as error:  # each library below has its own
            if tried == TRIES:
                why = " ".join(f"{type(error).__name__}: {error}".split())[:200]
                raise StoreError(
                    f"{without_password(what)} failed {TRIES} times ({why}); check the network "
                    f"and the rights."
                ) from None
            time.sleep(random.uniform(0.5, 1) * min(PAUSE * 2 ** (tried - 1), LONGEST_PAUSE))
    raise AssertionError
