"""Rows of motes: CSV and JSON Lines, with the columns of `motes track` or of `motes watch`.

Rows of `motes track` have an ellipse for each frame, those of `motes watch` a box for each object.
Rows made from other files have the ellipse if there is one object and it is turned, else the box.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any, Literal

import msgspec

from motes.core.errors import FormatError
from motes.core.geometry import Box, Ellipse
from motes.core.spreadsheet import guarded
from motes.core.track import Status
from motes.formats.recording import FilmFacts, Recorded, Recording, recording_of, sound
from motes.formats.text import at, whole
from motes.formats.visibility import SHOWN
from motes.output.journal import FrameRow, ObjectRow
from motes.output.read_rows import read_track
from motes.output.track_rows import COLUMNS, Form, line_of

OBJECT_COLUMNS = (
    "frame", "time", "identity", "x", "y", "width", "height", "confidence", "status", "occluded_by",
    "class",
)  # fmt: skip
DIGITS = {"time": 6, "x": 3, "y": 3, "a": 3, "b": 3, "distance": 5, "effective_sample_size": 2}
"""Digits of the columns of `motes track`; all others have 5."""
Values = Sequence[Any]
"""The fields of a row: numbers, texts, or None where a field is empty."""


def object_values(picture: FrameRow, each: ObjectRow) -> list[Any]:
    """Return the fields of an object's row, in order of `OBJECT_COLUMNS`."""
    return [
        picture.frame, round(picture.time, 6), each.identity,
        *(round(value, 3) for value in each.box), round(each.confidence, 5), each.status.value,
        each.occluded_by, each.label,
    ]  # fmt: skip


def object_line(form: Form, columns: Sequence[str], values: Values) -> str:
    """Return the row of an object as a line of CSV or of JSON Lines."""
    if form == "csv":
        return csv_line(values)
    return msgspec.json.encode(dict(zip(columns, values, strict=True))).decode()


def csv_line(values: Sequence[object]) -> str:
    """Return values as a line of CSV: None is empty, and a text that needs quotes has them.

    No text is a formula to a spreadsheet.
    """
    return ",".join(map(_csv_field, values))


def _csv_field(value: object) -> str:
    text = "" if value is None else guarded(str(value))
    if not any(mark in text for mark in ',"\r\n'):
        return text
    return '"' + text.replace('"', '""') + '"'


def table_of(recorded: Recorded) -> tuple[Sequence[str], Iterator[Values]]:
    """Return the columns and the rows of a recording."""
    identities, more, turned = set[int](), dict[str, None](), False
    for row in recorded:
        for each in row.objects:
            identities.add(each.identity)
            more |= dict.fromkeys(each.more)
            turned = turned or each.ellipse.theta != 0
    single = len(identities) <= 1 and (turned or "distance" in more)
    columns = COLUMNS if single else OBJECT_COLUMNS
    further = [name for name in more if name not in columns]
    values = _track_values(recorded, further) if single else _object_values(recorded, further)
    return (*columns, *further), values


def _track_values(recorded: Recorded, further: Sequence[str]) -> Iterator[Values]:
    for row in recorded:
        if not row.objects:
            empty = [None] * 6
            yield [row.frame, row.time, *empty, Status.SEARCHING.value, None, None,
                   *(None for _ in further)]  # fmt: skip
        for each in row.objects:
            yield [
                row.frame, row.time, *each.ellipse, each.confidence, each.status.value,
                *(each.more.get(name) for name in (*COLUMNS[-2:], *further)),
            ]  # fmt: skip


def _object_values(recorded: Recorded, further: Sequence[str]) -> Iterator[Values]:
    for row in recorded:
        for each in row.objects:
            yield [*object_values(row, each), *(each.more.get(name) for name in further)]


def write_csv(recorded: Recorded) -> Iterator[bytes]:
    """Yield a line of titles, and a line for each row."""
    yield from _lines(recorded, "csv")


def write_jsonl(recorded: Recorded) -> Iterator[bytes]:
    """Yield an object of JSON for each row."""
    yield from _lines(recorded, "jsonl")


def _lines(recorded: Recorded, form: Literal["csv", "jsonl"]) -> Iterator[bytes]:
    columns, rows = table_of(recorded)
    if form == "csv":
        yield ",".join(columns).encode() + b"\n"
    for values in rows:
        if "theta" in columns:
            fields = [_digits(name, value) for name, value in zip(columns, values, strict=True)]
            line = line_of(form, columns, fields)
        else:
            line = object_line(form, columns, values)
        yield line.encode() + b"\n"


def _digits(name: str, value: Any) -> str:
    if isinstance(value, float):
        return f"{value:z.{DIGITS.get(name, 5)}f}"
    return "" if value is None else str(value)


def read(path: Path, facts: FilmFacts) -> Recording:
    """Return the objects of rows of motes in CSV or JSON Lines."""
    table = read_track(path)
    names = table.dtype.names or ()
    return recording_of_rows(
        (dict(zip(names, row.tolist(), strict=True)) for row in table), names, facts
    )


def recording_of_rows(
    rows: Iterator[Mapping[str, Any]], names: Sequence[str], facts: FilmFacts
) -> Recording:
    """Return the objects of rows, each with a value for each name; NaN and "" are empty.

    Raises
    ------
    FormatError
        If they are rows of several cameras.
    """
    if "camera" in names:
        raise FormatError("its rows are of several cameras; keep those of one, without the column")
    times: dict[int, float | None] = {}
    objects = []
    for place, row in enumerate(rows, start=1):
        known = {name: value for name, value in row.items() if value not in ("", None)}
        known = {name: value for name, value in known.items() if value == value}  # NaN is empty
        with at(f"row {place}"):
            frame = whole(str(known["frame"]))
            if frame in times and "identity" not in names:
                raise ValueError(f"frame {frame} is there twice")
            times[frame] = float(known["time"]) if "time" in names else None
            each = _object(known, names)
            objects += [] if each is None else [(frame, each)]
    return recording_of(facts, objects, times)


def _object(row: Mapping[str, Any], names: Sequence[str]) -> ObjectRow | None:
    """Return the object of a row; None where it has no place, as one that is searched for."""
    turned = "theta" in names
    fields = Ellipse._fields if turned else Box._fields
    status = Status(row.get("status", Status.TRACKING))
    if status not in SHOWN and not any(name in row for name in fields):
        return None
    numbers = [float(row[name]) for name in fields]
    used = (*Ellipse._fields, *COLUMNS[:-2]) if turned else OBJECT_COLUMNS
    behind = row.get("occluded_by")
    more = {name: row[name] for name in names if name not in used and name in row}
    for name, value in more.items():
        if not isinstance(value, str | int | float):
            raise ValueError(f"{name} is not a number")
        if isinstance(value, float) and not math.isfinite(value):
            raise ValueError(f"{name} is {value}")
    sure = row["confidence"] if "confidence" in names and status is Status.TRACKING else 1.0
    found = ObjectRow(
        whole(str(row.get("identity", 1))),
        Ellipse(*numbers) if turned else Ellipse.from_box(numbers),
        float(row.get("confidence", sure)),
        status,
        None if behind is None else whole(str(behind)),
        row.get("class"),
        more=more,
    )
    return sound(found)
