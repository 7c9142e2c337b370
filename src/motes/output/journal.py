"""A journal: the objects of each frame, in a file that grows with the run.

Documents, which are whole only at the end, are made of it, so that a run that is killed loses no
frame. The first line is a `Head`, each other line a `Picture`, all of them JSON.
"""

from __future__ import annotations

import contextlib
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import Self

import msgspec

from motes.core.errors import SourceError
from motes.core.files import write_all
from motes.core.geometry import Box, Ellipse
from motes.core.track import Status
from motes.mot.tracked_object import SceneTrack

ENDING = ".rows.jsonl"
"""Follows the name of the document that a journal is for."""


class Sighting(msgspec.Struct, frozen=True, array_like=True):
    """An object in a frame; the fields are those of `SceneTrack` and its `Track`."""

    identity: int
    ellipse: Ellipse
    confidence: float
    status: Status
    occluded_by: int | None = None

    @classmethod
    def of(cls, each: SceneTrack) -> Self:
        """Return what is kept of an object."""
        track = each.track
        ellipse = Ellipse(*map(float, track.ellipse))  # callers' own may be numpy's
        return cls(each.identity, ellipse, float(track.confidence), track.status, each.occluded_by)

    @property
    def box(self) -> Box:
        """The axis-parallel box around the ellipse."""
        return self.ellipse.box


class Picture(msgspec.Struct, frozen=True, omit_defaults=True):
    """A frame: its index, its time in seconds, its objects, and its file if it is an image."""

    frame: int
    time: float
    objects: tuple[Sighting, ...]
    file: str | None = None


class Head(msgspec.Struct, frozen=True, tag_field="motes", tag="rows 1"):
    """What all pictures share: the source's name, their size in pixels, the objects' class."""

    source: str
    width: int
    height: int
    label: str


class JournalWriter:
    """Make a new journal and add pictures; each is in the file when `add` returns.

    Raises
    ------
    OSError
        If the file exists, even as a link to nowhere, or cannot be written. Then it ends with the
        last whole picture; it is removed if it has none.
    """

    def __init__(self, path: Path, head: Head) -> None:
        self.path = path
        # Exclusive: what is there may be a user's, or the journal of another run. Without a
        # buffer, nothing is left over that would fail once more when closed.
        self._file = path.open("xb", buffering=0)
        self._size = 0
        try:
            self._put(head)
        except BaseException:
            self.close()
            path.unlink(missing_ok=True)
            raise

    def add(self, picture: Picture) -> None:
        """Add a frame."""
        self._put(picture)

    def _put(self, line: Head | Picture) -> None:
        data = msgspec.json.encode(line) + b"\n"
        try:
            write_all(self._file, data)
        except OSError:
            with contextlib.suppress(OSError):
                self._file.truncate(self._size)
            raise
        self._size += len(data)

    def close(self) -> None:
        """Close the file."""
        self._file.close()


class Journal:
    """What a journal holds; a last line that was cut off is left out.

    Raises
    ------
    SourceError
        Here, if the file cannot be read or is none; from `pictures`, if a line is damaged.
    """

    def __init__(self, path: Path) -> None:
        self.path = path
        try:
            with path.open("rb") as file:
                self.head = msgspec.json.decode(file.readline(), type=Head)
                self._start = file.tell()
        except OSError as error:
            raise SourceError(f"{path} cannot be read: {error.strerror}; check the name.") from None
        except (msgspec.DecodeError, UnicodeDecodeError):
            raise SourceError(
                f"{path} does not hold the rows of a document; they are in a file NAME{ENDING}."
            ) from None

    def pictures(self, start: int = 0) -> Iterator[tuple[int, Picture]]:
        """Yield the frames, each after its offset in the file, from the one at an offset on."""
        decoder = msgspec.json.Decoder(Picture)
        try:
            with self.path.open("rb") as file:
                offset = file.seek(start or self._start)
                for line in file:
                    if not line.endswith(b"\n"):
                        return
                    yield offset, decoder.decode(line)
                    offset += len(line)
        except OSError as error:
            raise SourceError(f"{self.path} cannot be read: {error.strerror}.") from None
        except (msgspec.DecodeError, UnicodeDecodeError):
            raise SourceError(
                f"{self.path} is damaged at byte {offset}; remove the line there, and try again."
            ) from None

    def __iter__(self) -> Iterator[Picture]:
        return (picture for _, picture in self.pictures())


def journal_of(name: str) -> Path:
    """Return where the rows of a document are until it is made."""
    return Path(name + ENDING)


def sightings(tracks: Iterable[SceneTrack]) -> tuple[Sighting, ...]:
    """Return what is kept of the objects of a frame."""
    return tuple(Sighting.of(each) for each in tracks)
