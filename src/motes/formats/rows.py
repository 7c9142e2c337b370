"""Rows of motes: CSV and JSON Lines, with the columns of `motes track` or of `motes watch`.

Rows of `motes track` have an ellipse for each frame, those of `motes watch` a box for each object.
Rows made from other files have the ellipse if there is one object and it is turned, else the box.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any, Literal

import msgspec

from motes.core.errors import FormatError
from motes.core.geometry import Ellipse
from motes.core.track import Status
from motes.formats.recording import FilmFacts, Recorded, Recording, recording_of
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
    """Return values as a line of CSV: None is empty, and a text that needs quotes has them."""
    return ",".join(map(_csv_field, values))


def _csv_field(value: object) -> str:
    text = "" if value is None else str(value)
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
    times: dict[int, float] = {}
    objects = []
    for row in rows:
        known = {name: value for name, value in row.items() if value not in ("", None)}
        known = {name: value for name, value in known.items() if value == value}  # NaN is empty
        frame = int(known["frame"])
        times[frame] = float(known.get("time", facts.time(frame)))
        if "x" in known:
            objects.append((frame, _object(known, names)))
    return recording_of(facts, objects, times)


def _object(row: Mapping[str, Any], names: Sequence[str]) -> ObjectRow:
    if "theta" in names:
        ellipse = Ellipse(*(row[name] for name in Ellipse._fields))
        used: tuple[str, ...] = (*Ellipse._fields, *COLUMNS[:-2])
    else:
        ellipse = Ellipse.from_box([row[name] for name in ("x", "y", "width", "height")])
        used = OBJECT_COLUMNS
    behind = row.get("occluded_by")
    return ObjectRow(
        int(row.get("identity", 1)),
        ellipse,
        float(row.get("confidence", 1.0)),
        Status(row.get("status", Status.TRACKING)),
        None if behind is None else int(behind),
        row.get("class"),
        more={name: row[name] for name in names if name not in used and name in row},
    )
