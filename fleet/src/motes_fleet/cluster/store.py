"""Where results are kept: a folder, or an address of object storage (`objects.py`).

A file appears whole, or not at all. In a folder it is written under another name and renamed;
object storage shows a file when all of it has come. What a job makes does not depend on who makes
it. So two workers with the same job, as after a node was taken for dead, leave one result.
"""

from __future__ import annotations

import contextlib
import hashlib
import os
import secrets
import shutil
import tempfile
from collections.abc import Iterable, Iterator
from contextlib import AbstractContextManager
from pathlib import Path

from motes import FormatError
from motes.core import used_alone
from motes_fleet.cluster.objects import Objects

ATTEMPTS = "_attempts"
"""The folder of files that have no name yet. Datasets leave out names with this first letter."""


class Folder:
    """A folder with files by name, with slashes; for several machines, one that all of them see."""

    def __init__(self, path: Path) -> None:
        self.path = path

    def write(self, name: str, data: bytes | Path) -> None:
        """Make a file, or replace it; a file of `scratch` is renamed.

        Raises
        ------
        FormatError
            If it cannot be written.
        """
        goal = self.path / name
        new = data if isinstance(data, Path) else self.path / ATTEMPTS / secrets.token_hex(8)
        try:
            goal.parent.mkdir(parents=True, exist_ok=True)
            if isinstance(data, bytes):
                new.parent.mkdir(parents=True, exist_ok=True)
                new.write_bytes(data)
            with new.open("rb+") as file:
                os.fsync(file.fileno())  # before it has its name, also after a loss of power
            new.replace(goal)
        except OSError as error:
            new.unlink(missing_ok=True)
            raise FormatError(
                f"{goal} cannot be written: {error.strerror}; make room, or choose another place."
            ) from None

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

    def remove(self, name: str) -> None:
        """Remove a file, or a folder with all that is in it, if it is there."""
        path = self.path / name
        if path.is_dir():
            shutil.rmtree(path, ignore_errors=True)
        else:
            path.unlink(missing_ok=True)

    def scratch(self) -> AbstractContextManager[str]:
        """Return a new folder on the same disk, whose files `write` renames."""
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
        taken = (
            f"Another motes batch writes into {self.path}; wait for it, or choose another folder."
        )
        with used_alone(self.path, lambda _: taken):
            self.remove(ATTEMPTS)
            yield
            self.remove(ATTEMPTS)


Store = Folder | Objects


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
    return Objects(address) if "://" in address else Folder(Path(address).absolute())


def sha256(path: Path) -> str:
    """Return the checksum of a file."""
    with path.open("rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()
