"""Files and folders that are complete or absent: they get their names when all is written.

Until then a partial file stands beside the target, as `out.mp4.partial-3f9c1a7be2d05846.mp4`.
It replaces no file, follows no link, and only its own run removes it: see `leftovers`.
"""

from __future__ import annotations

import contextlib
import errno
import glob
import os
import secrets
import shutil
from collections.abc import Callable, Iterable, Iterator
from pathlib import Path
from typing import Any, BinaryIO

from motes.core import platforms
from motes.core.errors import ConfigError, FormatError, MotesError, SourceError

PARTIAL = ".partial-" + "[0-9a-f]" * 16
"""Pattern of the part of a partial file's name that follows the target's name."""
LOCK = "_lock"
"""The file that is locked while a program uses a folder alone."""


def leftovers(target: str | Path) -> list[Path]:
    """Return the partial files of a target, from runs that were killed or have not ended yet."""
    path = _followed(target)
    return sorted(path.parent.glob(glob.escape(path.name) + PARTIAL + "*"))


def _followed(path: str | Path) -> Path:
    return Path(os.path.realpath(path) if os.path.islink(path) else path)


def same_file(one: str | Path, other: str | Path) -> bool:
    """Return whether two names mean the same file, also by a link. The file may be missing."""
    try:
        return os.path.samefile(one, other)
    except OSError:
        return os.path.realpath(one) == os.path.realpath(other)


def is_special(path: str | Path) -> bool:
    """Return whether a path is a pipe, a device or similar, which must not be replaced."""
    return os.path.exists(path) and not os.path.isfile(path)


def check_writable(path: str | Path, overwrite: bool = False) -> None:
    """Check that a file can be made at `path`; an existing device or pipe is allowed.

    Raises a FormatError if a file exists and must not be overwritten, or the folder is missing or
    protected.
    """
    path = Path(path)
    if path.is_dir():
        raise FormatError(f"{path} is a folder; give the name of a file.")
    if path.is_file() and not overwrite:
        raise FormatError(
            f"{path} exists; choose another name, or allow it "
            f"(overwrite=True, on the command line --overwrite)."
        )
    if not path.parent.is_dir():
        raise FormatError(f"There is no folder {path.parent} for {path.name}; make it first.")
    if not os.access(path if path.exists() else path.parent, os.W_OK):
        raise FormatError(f"{path} cannot be written: no permission; choose another place.")


def open_rows(path: str | Path, overwrite: bool) -> BinaryIO:
    """Open a file that grows row by row, unbuffered; raise an OSError if it appeared meanwhile.

    The file, or the target of a link, may be missing. With `overwrite`, an old file is removed; a
    run that still writes it ends with an error.
    """
    if is_special(path):
        return open(path, "wb", buffering=0)
    if overwrite:
        _followed(path).unlink(missing_ok=True)
    return open(_followed(path), "xb", buffering=0)


def as_path(path: Any) -> Path:
    """Return a path; raise a ConfigError if it is none."""
    try:
        return Path(path)
    except TypeError:
        raise ConfigError(f"Give the name of a file; got {path!r}.") from None


def read_text(
    path: str | Path, kind: type[MotesError] = SourceError, newline: str | None = None
) -> str:
    """Return the text of a file in UTF-8; raise an error of a kind if it cannot be read.

    With the `newline` "", its ends of lines stay as they are.
    """
    as_path(path)
    try:
        with open(path, encoding="utf-8-sig", newline=newline) as file:
            return file.read()
    except (OSError, UnicodeDecodeError) as error:
        reason = "it is not text; save it as UTF-8"
        if isinstance(error, OSError):
            reason = f"{error.strerror}; check the name"
        raise kind(f"{path} cannot be read: {reason}.") from None


def lines_of(text: str) -> list[str]:
    """Return the lines of a text; no character but the line feed ends one."""
    return text.removesuffix("\n").split("\n")


def check_ended(text: str) -> None:
    """Raise a ValueError if the last line of a text has no end: the file may be cut off in it."""
    if text.rpartition("\n")[2].strip():
        raise ValueError(
            "its last line has no end, so it may be cut off there; if it is whole, end the line"
        )


def write_all(file: BinaryIO, data: bytes | memoryview) -> None:
    """Write all of `data` into an unbuffered file, which may take it piece by piece."""
    rest = memoryview(data)
    while rest:
        rest = rest[file.write(rest) :]


def write_whole(path: str | Path, data: bytes | Iterable[bytes]) -> None:
    """Write a file. If that fails, as on a full disk, the old file stays.

    Pieces are written as they come; about one megabyte of them is in memory at a time.
    """
    pieces = [data] if isinstance(data, bytes) else data
    if is_special(path):
        with open(path, "wb") as file:
            file.writelines(pieces)
        return
    partial = PartialFile(path)
    try:
        waiting = bytearray()
        for piece in pieces:
            waiting += piece
            if len(waiting) > 1 << 20:
                partial.write(waiting)
                waiting.clear()
        partial.write(waiting)
        partial.finish(overwrite=True)
    except BaseException:
        partial.drop()
        raise


@contextlib.contextmanager
def writing(path: object) -> Iterator[None]:
    """Raise a FormatError that names a file, or a folder, where it cannot be written."""
    try:
        yield
    except OSError as error:
        raise FormatError(
            f"{path} cannot be written: {error.strerror}; make room, or choose another place."
        ) from error


def write_folder(path: str | Path, files: Iterable[tuple[str, bytes]]) -> None:
    """Write a folder of files, which gets its name when all of them are written.

    A name may have a folder before it.

    An old folder of that name is replaced, with all that it holds. If writing fails, as on a full
    disk, the old one stays.
    """
    target = _followed(path)
    partial, old = (target.with_name(_partial_name(target)) for _ in range(2))
    partial.mkdir()
    try:
        for name, data in files:
            (partial / name).parent.mkdir(exist_ok=True)
            with (partial / name).open("xb", buffering=0) as file:
                write_all(file, data)
                os.fsync(file.fileno())  # some file systems report only then that they are full
        if target.exists():
            target.rename(old)
        partial.rename(target)
    except BaseException:
        shutil.rmtree(partial, ignore_errors=True)
        raise
    shutil.rmtree(old, ignore_errors=True)


@contextlib.contextmanager
def used_alone(folder: Path, taken: Callable[[str], str]) -> Iterator[BinaryIO]:
    """Keep others out of a folder, which is made; a kill ends that too.

    Raises a FormatError if another program uses the folder, or it cannot be made. `taken` returns
    the message if another program uses it, of what that one has written. Yields a file, into which
    a text for the others may be written.
    """
    try:
        folder.mkdir(parents=True, exist_ok=True)
        lock = (folder / LOCK).open("ab+", buffering=0)
    except OSError as error:
        raise FormatError(
            f"The folder {folder} cannot be made: {error.strerror}; choose another one."
        ) from None
    with lock:
        lock.seek(0)
        try:
            platforms.lock(lock)
        except OSError:
            text = b""
            with contextlib.suppress(OSError):  # Windows lets nobody read it
                text = lock.read()
            raise FormatError(taken(text.decode(errors="replace"))) from None
        lock.truncate()
        yield lock


def _partial_name(target: Path) -> str:
    return f"{target.name}.partial-{secrets.token_hex(8)}"


class PartialFile:
    """A new file beside its target, which becomes the target in the end.

    Appended data is in the file at once. Changes of older data wait for the end. So a program that
    is killed at any moment leaves a file that only lacks its end. Raises an OSError here and from
    all methods, if the file system refuses. If the target is a link, the file behind the link is
    meant. `path` is the partial file, and `whole` is whether it has become the target.
    """

    def __init__(self, target: str | Path, ending: str = "") -> None:
        self._target = _followed(target)
        self.path = self._target.with_name(_partial_name(self._target) + ending)
        self.whole = False
        self._file = self.path.open("xb", buffering=0)
        self._size = self._place = 0
        self._changes: list[tuple[int, bytes]] = []

    def write(self, data: bytes | bytearray | memoryview) -> int:
        """Write all of `data` at the current place; a failed append leaves no trace."""
        view = memoryview(data)
        old = max(self._size - self._place, 0)
        if old:
            self._changes.append((self._place, bytes(view[:old])))
        try:
            self._put(self._size, view[old:])
        except OSError:
            with contextlib.suppress(OSError):
                self._file.truncate(self._size)
            raise
        self._size += len(view[old:])
        self._place += len(view)
        return len(view)

    def _put(self, place: int, data: bytes | memoryview) -> None:
        self._file.seek(place)
        write_all(self._file, data)

    def seek(self, offset: int, whence: int = os.SEEK_SET) -> int:
        """Go to another place for the next `write`, at most to the end; return it."""
        start = {os.SEEK_SET: 0, os.SEEK_CUR: self._place, os.SEEK_END: self._size}[whence]
        self._place = start + offset
        return self._place

    def tell(self) -> int:
        """Return the place of the next `write`."""
        return self._place

    def settle(self) -> None:
        """Write the changes that have waited."""
        for place, data in self._changes:
            self._put(place, data)
        self._changes.clear()

    def close(self) -> None:
        """Close the file as it is, a partial one unless it is finished."""
        self._file.close()

    def finish(self, *, overwrite: bool) -> None:
        """Write the changes that have waited, and give the file the target's name.

        Raises a FileExistsError if the target exists and must not be overwritten.
        """
        self.settle()
        os.fsync(self._file.fileno())  # some file systems report only then that they are full
        self.close()
        if not overwrite and self._target.exists():
            raise FileExistsError(errno.EEXIST, os.strerror(errno.EEXIST), str(self._target))
        self.path.replace(self._target)
        self.whole = True

    def drop(self) -> None:
        """Remove the partial file, if it has not become the target."""
        self.close()
        if not self.whole:
            self.path.unlink(missing_ok=True)
