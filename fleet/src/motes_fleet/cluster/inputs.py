"""The files that a job reads: whether they changed, their checksums, copies of remote ones."""

from __future__ import annotations

import glob
import hashlib
import os
import posixpath
from collections.abc import Iterable
from pathlib import Path

import msgspec

from motes import SourceError
from motes.correction import History
from motes_fleet.cluster.jobs import Job
from motes_fleet.cluster.objects import Objects
from motes_fleet.cluster.store import sha256


class InputFile(msgspec.Struct, frozen=True):
    """A file, or the files of a folder or pattern, as a job has read it."""

    path: str
    """Its name or address."""
    stamp: str
    """What the file system or server notes of it: it is another one after each change. Empty if it
    is missing."""
    sha256: str
    """The checksum of its content."""


def paths_of(job: Job) -> list[str]:
    """Return the files that a job reads, its source first."""
    found = [path for _, path in job.files]
    history = None if job.rows is None else f"{job.rows}{History.ENDING}"
    return [*found, history] if history is not None and stamp(history) else found


def stamp(path: str) -> str:
    """Return a text that changes with a file, or those of a folder or pattern; "" if missing."""
    if "://" in path:
        return Objects(path).stamp()
    marks = [f"{(each := os.stat(file)).st_size} {each.st_mtime_ns}" for file in _files(path)]
    return _digest(marks) if len(marks) > 1 else "".join(marks)


def _files(path: str) -> list[str]:
    """Return the files of a name: one, those of a folder, or those of a pattern."""
    if os.path.isdir(path):
        return sorted(entry.path for entry in os.scandir(path) if entry.is_file())
    if not os.path.exists(path) and glob.has_magic(path):
        return sorted(glob.glob(path, recursive=True))
    return [path] if os.path.exists(path) else []


def _digest(parts: list[str]) -> str:
    return hashlib.sha256("\n".join(parts).encode()).hexdigest()


def checksum(path: str) -> str:
    """Return the checksum of a file's content; for several files, that of their checksums."""
    files = _files(path)
    if len(files) == 1:
        return sha256(Path(files[0]))
    return _digest([f"{os.path.basename(file)} {sha256(Path(file))}" for file in files])


def localized(job: Job, folder: Path) -> tuple[Job, tuple[InputFile, ...]]:
    """Return a job whose files are on this machine, and what they are.

    Copies of remote files go into the folder.

    Raises
    ------
    SourceError
        If a file is missing.
    StoreError
        If it cannot be fetched.
    """
    places, inputs = dict[str, str](), list[InputFile]()
    for number, path in enumerate(paths_of(job)):
        before, places[path] = stamp(path), path
        if not before:
            raise SourceError(f"{path} is missing; check the name.")
        if "://" in path:
            goal = folder / str(number) / posixpath.basename(path.rstrip("/"))
            goal.parent.mkdir(parents=True)
            Objects(path).fetch(goal)
            places[path] = str(goal)
        inputs.append(InputFile(path, before, checksum(places[path])))
    return job.with_files(places.__getitem__), tuple(inputs)


def changed(inputs: Iterable[InputFile]) -> bool:
    """Return whether a file is missing now, or its content is another one than before.

    Where the stamp of a file has changed, its checksum decides. What a server holds is known by its
    stamp alone.
    """
    for each in inputs:
        now = stamp(each.path)
        if now != each.stamp and (
            not now or "://" in each.path or checksum(each.path) != each.sha256
        ):
            return True
    return False
