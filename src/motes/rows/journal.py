"""A journal: the objects of each frame, in a file that grows with the run.

Annotation documents are complete only at the end of a run and are made from the journal; a run that
is killed loses no frame. The first line is a `Header`, each other line a `FrameRow`, all in JSON.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, Self

import msgspec
from msgspec.structs import replace

from motes.core.labels import check_label
from motes.core.track import COLUMNS, Track
from motes.rows import schema

ENDING = ".rows.jsonl"
"""Added to the name of a document, this is the name of its journal."""


class FrameRow(msgspec.Struct, frozen=True, eq=False):
    """A frame: its index, its time in seconds, its objects, and its file if it is an image.

    Attributes
    ----------
    searched
        Identities of objects that are searched for and have no place, where `objects` lacks them.
    """

    frame: int
    time: float
    objects: tuple[Track, ...]
    file: str | None = None
    searched: tuple[int, ...] = ()

    def values(self, each: Track, further: Sequence[str] = ()) -> list[Any]:
        """Return the fields of an object's row: those of `COLUMNS`, and of further columns.

        Raises
        ------
        ConfigError
            If the name of its class is one that a file cannot hold.
        """
        if each.label:
            check_label(each.label)
        more = schema.further(each)
        return [*each.to_dict().values(), *(more.get(name) for name in further)]

    def to_dict(self) -> dict[str, Any]:
        """Return what `from_dict` takes, for JSON; raise a ConfigError as `values` does."""
        objects = []
        for each in self.objects:
            names = *COLUMNS, *schema.further(each)
            row = dict(zip(names, self.values(each, names[len(COLUMNS) :]), strict=True))
            objects.append(row if each.mask is None else row | {"mask": each.mask})
        return {
            "frame": self.frame, "time": self.time, "objects": objects, "file": self.file,
            "searched": self.searched,
        }  # fmt: skip

    @classmethod
    def from_dict(cls, values: Mapping[str, Any]) -> Self:
        """Return the frame of a line of a journal.

        Raises
        ------
        AttributeError, KeyError, TypeError, ValueError
            If a value is missing or damaged.
        """
        objects = msgspec.convert(values["objects"], list[dict[str, int | float | str | None]])
        tracks = tuple(_track(each) for each in objects)
        row = replace(msgspec.convert({**values, "objects": ()}, cls), objects=tracks)
        if any(each.frame != row.frame for each in tracks):
            raise ValueError("an object of another frame")
        return row


def _track(row: dict[str, int | float | str | None]) -> Track:
    if missing := [name for name in COLUMNS if name not in row]:
        raise KeyError(missing[0])
    mask, label = row.pop("mask", None), row.get("label")
    if label is not None:
        check_label(label)  # a number is a TypeError
    return replace(Track.from_dict(row), mask=None if mask is None else str(mask))


class Header(msgspec.Struct, frozen=True, tag_field="motes", tag="rows 2"):
    """What all frames share: the source's name, the size in pixels, the usual class of objects."""

    source: str
    width: int
    height: int
    label: str


def journal_of(name: str) -> Path:
    """Return the path of a document's journal."""
    return Path(f"{Path(name)}{ENDING}")  # a folder's name may end in a slash


def text_name(name: str) -> str:
    """Return the name of a file with escapes for bytes that are no text, as of old disks."""
    return name.encode(errors="backslashreplace").decode()
