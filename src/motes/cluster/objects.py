"""Files at addresses (S3, Google's storage, HTTP, ...) through fsspec; requests are repeated.

Networks fail: a request may be refused, stall, or lose its connection, perhaps after the server has
done what it asked for. So each request has a time limit and is tried again, after growing pauses.
All of them can be: what is created only if it is missing is compared when it seems to be there.
"""

from __future__ import annotations

import functools
import random
import time
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import Any, Self, TypeVar

from motes.core.addresses import without_password
from motes.core.errors import ConfigError, FormatError, MissingDependencyError

T = TypeVar("T")


class StoreError(FormatError):
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
FINAL = (FileNotFoundError, FileExistsError, PermissionError, IsADirectoryError, ImportError)
"""Errors that no second try mends."""


class Objects:
    """The files of one kind of address."""

    def __init__(self, files: Any) -> None:
        self._files = files

    @classmethod
    @functools.cache
    def _of_protocol(cls, protocol: str) -> Self:
        try:
            import fsspec
        except ImportError:
            raise MissingDependencyError(
                f"{protocol}:// needs fsspec; install it with: pip install 'motes[cloud]'."
            ) from None
        try:
            return cls(fsspec.filesystem(protocol, **OPTIONS.get(protocol, {})))
        except ValueError:
            raise ConfigError(f"{protocol}:// is no kind of address that fsspec knows.") from None
        except ImportError as error:
            raise MissingDependencyError(f"{protocol}:// needs a package: {error}.") from None

    @classmethod
    def of(cls, address: str) -> tuple[Self, str]:
        """Return the files of an address's kind, and its key among them.

        Raises
        ------
        ConfigError
            If the kind is not known.
        MissingDependencyError
            If fsspec, or its package for this kind, is not installed.
        """
        protocol = address.partition("://")[0].lower()
        found = cls._of_protocol(protocol)
        key: str = found._files._strip_protocol(address)
        return found, key.rstrip("/")

    def put(self, key: str, data: bytes | Path, *, create: bool) -> bool:
        """Make a file; with `create`, return False if it is there."""
        mode = "create" if create else "overwrite"

        def send() -> None:
            if isinstance(data, Path):
                self._files.put_file(str(data), key, mode=mode)
            else:
                self._files.pipe_file(key, data, mode=mode)

        try:
            _repeated(send, key)
        except FileExistsError:
            return False
        except OSError as error:
            raise FormatError(f"{key} cannot be written: {error}; check the rights.") from None
        return True

    def read(self, keys: Sequence[str]) -> dict[str, bytes]:
        """Return the content of those files that are there; they are read at the same time."""
        if not keys:
            return {}
        found: dict[str, bytes] = {}

        def load() -> None:
            left = [key for key in keys if key not in found]
            answers = self._files.cat(left, on_error="return")
            failed = None
            for key, answer in answers.items():
                if isinstance(answer, bytes):
                    found[key] = answer
                elif not isinstance(answer, FileNotFoundError):
                    failed = answer
            if failed is not None:
                raise failed

        _repeated(load, keys[0])
        return found

    def fetch(self, key: str, goal: Path) -> None:
        """Copy a file to this machine."""
        _repeated(lambda: self._files.get_file(key, str(goal)), key)

    def stamp(self, key: str) -> str | None:
        """Return a text that changes when a file is written again; None if it is missing."""
        try:
            info = _repeated(lambda: self._files.info(key), key)
        except FileNotFoundError:
            return None
        marks = ("ETag", "etag", "size", "LastModified", "mtime", "updated")
        return " ".join(str(info[mark]) for mark in marks if info.get(mark) is not None)

    def names(self, folder: str) -> Iterator[str]:
        """Yield the names in a folder."""
        try:
            found = _repeated(lambda: self._files.ls(folder, detail=False), folder)
        except FileNotFoundError:
            return
        for key in found:
            yield key.rstrip("/").rpartition("/")[2]

    def remove(self, key: str) -> None:
        """Remove a file, or a folder with all that is in it, if it is there."""

        def remove() -> None:
            if self._files.exists(key):
                self._files.rm(key, recursive=True)

        try:
            _repeated(remove, key)
        except FileNotFoundError:
            return


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
