"""Where results are kept: a folder, or an address of object storage.

A file appears once and whole, or not at all. In a folder it is written under another name and
linked to its own, which fails if that is taken. Object storage is asked to create it only if it is
not there (If-None-Match on S3). So two workers with the same job, as after a node was taken for
dead, leave one result.
"""

from __future__ import annotations

import contextlib
import fcntl
import hashlib
import os
import secrets
import shutil
import tempfile
from collections.abc import Iterable, Iterator
from contextlib import AbstractContextManager
from pathlib import Path
from typing import Protocol

from motes.cluster.objects import Objects
from motes.core.errors import FormatError

ATTEMPTS = "_attempts"
"""The folder of files that have no name yet. Datasets leave out names with this first letter."""
LOCK = "_lock"
"""The file that is locked while a batch writes into a folder."""


class Store(Protocol):
    """Files by name, with slashes."""

    def create(self, name: str, data: bytes | Path) -> bool:
        """Make a file; return False, and change nothing, if it is there."""
        ...

    def replace(self, name: str, data: bytes | Path) -> None:
        """Make a file, or replace it."""
        ...

    def read(self, names: Iterable[str]) -> dict[str, bytes]:
        """Return the content of those files that are there."""
        ...

    def lines(self, name: str) -> Iterator[bytes]:
        """Yield the lines of a file, which is not held in memory."""
        ...

    def names(self, folder: str) -> Iterator[str]:
        """Yield the names in a folder, without the folder's."""
        ...

    def remove(self, folder: str) -> None:
        """Remove a file, or a folder with all that is in it, if it is there."""
        ...

    def scratch(self) -> AbstractContextManager[str]:
        """Return a new folder on this machine, from which files come into the store quickly."""
        ...

    def used_alone(self) -> AbstractContextManager[None]:
        """Keep other batches out, where that is possible, and remove what killed ones left."""
        ...


def open_store(address: str) -> Store:
    """Return the store of a folder's name or of an address.

    Raises
    ------
    ConfigError
        If the address is of no known kind.
    MissingDependencyError
        If fsspec is not installed.
    """
    address = address.removeprefix("file://")
    if "://" in address:
        return ObjectStore(address)
    return Folder(Path(address).absolute())


class Folder:
    """A folder; for several machines, one that all of them see."""

    def __init__(self, path: Path) -> None:
        self.path = path

    def create(self, name: str, data: bytes | Path) -> bool:
        """Make a file; return False, and change nothing, if it is there."""
        with self._new(name, data) as new:
            try:
                os.link(new, self.path / name)
            except FileExistsError:
                return False
        return True

    def replace(self, name: str, data: bytes | Path) -> None:
        """Make a file, or replace it."""
        with self._new(name, data) as new:
            os.replace(new, self.path / name)

    @contextlib.contextmanager
    def _new(self, name: str, data: bytes | Path) -> Iterator[Path]:
        """Give a file with the data under another name: the file itself, or one that is removed."""
        goal = self.path / name
        new = data if isinstance(data, Path) else self.path / ATTEMPTS / secrets.token_hex(8)
        try:
            goal.parent.mkdir(parents=True, exist_ok=True)
            new.parent.mkdir(parents=True, exist_ok=True)
            with new.open("rb+" if isinstance(data, Path) else "xb") as file:
                if not isinstance(data, Path):
                    file.write(data)
                    file.flush()
                os.fsync(file.fileno())  # before it has its name, also after a loss of power
            yield new
        except OSError as error:
            raise FormatError(
                f"{goal} cannot be written: {error.strerror}; make room, or choose another place."
            ) from None
        finally:
            if not isinstance(data, Path):
                new.unlink(missing_ok=True)

    def read(self, names: Iterable[str]) -> dict[str, bytes]:
        """Return the content of those files that are there."""
        found = {}
        for name in names:
            with contextlib.suppress(FileNotFoundError):
                found[name] = (self.path / name).read_bytes()
        return found

    def lines(self, name: str) -> Iterator[bytes]:
        """Yield the lines of a file, which is not held in memory."""
        with (self.path / name).open("rb") as file:
            yield from file

    def names(self, folder: str) -> Iterator[str]:
        """Yield the names in a folder, without the folder's."""
        with contextlib.suppress(FileNotFoundError), os.scandir(self.path / folder) as entries:
            for entry in entries:
                yield entry.name

    def remove(self, folder: str) -> None:
        """Remove a file, or a folder with all that is in it, if it is there."""
        path = self.path / folder
        if path.is_dir():
            shutil.rmtree(path, ignore_errors=True)
        else:
            path.unlink(missing_ok=True)

    def scratch(self) -> AbstractContextManager[str]:
        """Return a new folder on the same disk."""
        (self.path / ATTEMPTS).mkdir(parents=True, exist_ok=True)
        return tempfile.TemporaryDirectory(dir=self.path / ATTEMPTS)

    @contextlib.contextmanager
    def used_alone(self) -> Iterator[None]:
        """Keep other batches out, and remove what killed ones left.

        Raises
        ------
        FormatError
            If another batch writes here, or the folder cannot be made.
        """
        try:
            self.path.mkdir(parents=True, exist_ok=True)
            lock = (self.path / LOCK).open("wb")
        except OSError as error:
            raise FormatError(
                f"The folder {self.path} cannot be made: {error.strerror}; choose another one."
            ) from None
        with lock:
            try:
                fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
            except OSError:
                raise FormatError(
                    f"Another motes batch writes into {self.path}; wait for it, or choose another "
                    f"folder."
                ) from None
            self.remove(ATTEMPTS)
            yield
            self.remove(ATTEMPTS)


class ObjectStore:
    """A prefix of object storage."""

    def __init__(self, address: str) -> None:
        self._objects, self._root = Objects.of(address)

    def _key(self, name: str) -> str:
        return f"{self._root}/{name}"

    def create(self, name: str, data: bytes | Path) -> bool:
        """Make a file; return False, and change nothing, if it is there."""
        return self._objects.put(self._key(name), data, create=True)

    def replace(self, name: str, data: bytes | Path) -> None:
        """Make a file, or replace it."""
        self._objects.put(self._key(name), data, create=False)

    def read(self, names: Iterable[str]) -> dict[str, bytes]:
        """Return the content of those files that are there."""
        keys = {self._key(name): name for name in names}
        return {keys[key]: data for key, data in self._objects.read([*keys]).items()}

    def lines(self, name: str) -> Iterator[bytes]:
        """Yield the lines of a file, of which a copy is made."""
        with self.scratch() as folder:
            copy = Path(folder) / "copy"
            self._objects.fetch(self._key(name), copy)
            with copy.open("rb") as file:
                yield from file

    def names(self, folder: str) -> Iterator[str]:
        """Yield the names in a folder, without the folder's."""
        yield from self._objects.names(self._key(folder))

    def remove(self, folder: str) -> None:
        """Remove a file, or a folder with all that is in it, if it is there."""
        self._objects.remove(self._key(folder))

    def scratch(self) -> AbstractContextManager[str]:
        """Return a new folder."""
        return tempfile.TemporaryDirectory(prefix="motes-")

    def used_alone(self) -> AbstractContextManager[None]:
        """Do nothing: who creates a file first is known, and others leave no parts."""
        return contextlib.nullcontext()


def sha256(path: Path) -> str:
    """Return the checksum of a file."""
    with path.open("rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()


def same(store: Store, name: str, digest: str) -> bool:
    """Return whether a file of a store has a checksum."""
    data = store.read([name]).get(name)
    return data is not None and hashlib.sha256(data).hexdigest() == digest
