"""The columns of rows: the same for one object and for many, tracked, corrected or converted.

A row is an object in a frame. Numbers have fixed digits and are never NaN or infinite, so equal
runs give equal bytes; what is not known is an empty field in CSV, and null in JSON Lines.

Annotation documents are complete only at the end of a run, and are made from a journal of its
frames, so that a run that is killed loses none. Its first line is a `Header`, each other line a
`FrameRow`, all in JSON.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import lru_cache
from math import isfinite, sqrt
from pathlib import Path
from typing import Any, Literal, Self

import msgspec
from msgspec.structs import replace

from motes.core.errors import ConfigError
from motes.core.files import as_path
from motes.core.labels import check_label, guarded
from motes.core.track import BOX, COLUMNS, DEVIATIONS, ELLIPSE, GROUND, ROUNDING, Track

Form = Literal["csv", "jsonl"]
FORMS: dict[str, Form] = {".csv": "csv", ".jsonl": "jsonl"}
"""The form of each file ending."""

HINDSIGHT = (*DEVIATIONS, "outlier")
"""Further columns of tracks that are known in hindsight: smoothed or corrected ones."""
CAMERA = "camera"
"""The further column of rows of several cameras."""
KNOWN = (*COLUMNS, *HINDSIGHT, *GROUND)
"""All columns of an object that have a meaning."""

WHOLE = ("frame", "id")
"""Columns of whole numbers."""
TEXT = ("label", "status", CAMERA)
"""Columns of text."""
NUMBERS = tuple(name for name in KNOWN if name not in WHOLE and name not in TEXT)
"""Columns of numbers, which may be empty."""
DIGITS = {"time": "z.6f", "effective_sample_size": "z.2f", "outlier": "z.0f"}
DIGITS |= dict.fromkeys((*BOX, *ELLIPSE[:-1]), "z.3f")
"""How the numbers of a column are written; others have five digits after the point."""


def form_of(path: str | Path, form: Form | None = None) -> Form:
    """Return the form of a file: `form` if given, else that of the file's ending; `-` is CSV.

    Raises a ConfigError if the ending is unknown.
    """
    if form is not None:
        return form
    if str(path) == "-":
        return "csv"
    ending = as_path(path).suffix.lower()
    if ending not in FORMS:
        raise ConfigError(
            f"{path} ends neither in .csv nor in .jsonl, as rows of motes do; motes convert makes "
            f"such rows of other formats."
        )
    return FORMS[ending]


def further(track: Track) -> Mapping[str, float | str | None]:
    """Return the further columns of a track; one in hindsight has those of `HINDSIGHT`."""
    if not track.smoothed:
        return track.further
    deviations = [sqrt(each) for each in track.covariance.diagonal().tolist()]
    known = dict(zip(DEVIATIONS, deviations, strict=True))
    return {**known, "outlier": int(track.outlier), **track.further}


def head(form: Form, columns: Sequence[str]) -> list[str]:
    """Return the lines before the first row."""
    return [",".join(columns)] if form == "csv" else []


def line(form: Form, columns: Sequence[str], values: Sequence[Any]) -> str:
    """Return a row as a line; a value is a number, a text, or None where the field is empty.

    Numbers have the digits of their columns, and zero has no sign; what is not finite is empty.
    """
    csv = form == "csv"
    fields = [
        "" if value is None
        else (quoted(value) if csv else _json(value)) if isinstance(value, str)
        else str(value) if isinstance(value, int)
        else _number(name, value) if isfinite(value) else ""
        for name, value in zip(columns, values, strict=True)
    ]  # fmt: skip
    if csv:
        return ",".join(fields)
    pairs = zip(columns, fields, strict=True)
    return "{" + ", ".join([f'"{name}": {field or "null"}' for name, field in pairs]) + "}"


def _number(name: str, value: float) -> str:
    """Return a number; metres below a centimetre, as of a microscope, have five digits."""
    small = name in GROUND and ROUNDING < abs(value) < 1e-2
    return format(value, ".5g" if small else DIGITS.get(name, "z.5f"))


@lru_cache(1000)
def quoted(text: str) -> str:
    """Return a text as a field of CSV: it has quotes if need be, and is no formula."""
    text = guarded(text)
    if not any(mark in text for mark in ',"\r\n'):
        return text
    return '"' + text.replace('"', '""') + '"'


@lru_cache(1000)
def _json(text: str) -> str:
    return msgspec.json.encode(text).decode()


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

    def values(self, each: Track, names: Sequence[str] = ()) -> list[Any]:
        """Return the fields of an object's row: those of `COLUMNS`, and of further ones by name.

        Raises a ConfigError if the name of its class is one that a file cannot hold.
        """
        if each.label:
            check_label(each.label)
        more = further(each)
        return [*each.to_dict().values(), *(more.get(name) for name in names)]

    def to_dict(self) -> dict[str, Any]:
        """Return what `from_dict` takes, for JSON; raise a ConfigError as `values` does."""
        objects = []
        for each in self.objects:
            more = [*further(each)]
            row = dict(zip((*COLUMNS, *more), self.values(each, more), strict=True))
            objects.append(row if each.mask is None else row | {"mask": each.mask})
        return {
            "frame": self.frame, "time": self.time, "objects": objects, "file": self.file,
            "searched": self.searched,
        }  # fmt: skip

    @classmethod
    def from_dict(cls, values: Mapping[str, Any]) -> Self:
        """Return the frame of a line of a journal.

        Raises an AttributeError, KeyError, TypeError or ValueError if a value is missing or
        damaged.
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
