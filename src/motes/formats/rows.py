"""Rows of motes: CSV and JSON Lines, with the columns of `motes.rows.schema`.

Rows of others may lack the ellipse, if they have a box, and all else but the frame.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

import msgspec

from motes.core.errors import FormatError, SourceError
from motes.core.geometry import Box, Ellipse, check_angle
from motes.core.track import Status
from motes.formats.recording import ANONYMOUS, FilmFacts, Recording, recording_of, sound
from motes.formats.text import at, whole
from motes.formats.visibility import SHOWN
from motes.rows.journal import ENDING, FrameRow, Header, ObjectRow
from motes.rows.reader import read_track
from motes.rows.schema import (
    BOX,
    CAMERA,
    COLUMNS,
    ELLIPSE,
    GROUND,
    HINDSIGHT,
    Form,
    head,
    line,
)

KNOWN = (*COLUMNS, *HINDSIGHT, *GROUND)
"""The columns that are read; others are left out."""


def table_of(recorded: Recording) -> tuple[Sequence[str], Iterator[Sequence[Any]]]:
    """Return the columns and the rows of a recording.

    If there is one object, and it was followed, it has a row in all frames: it is searched for
    where it is not there. Boxes of others are silent on frames without one.
    """
    every = [each for row in recorded for each in row.objects]
    further = dict.fromkeys(name for each in every for name in each.more)
    alone = every and (recorded.single or (not recorded.told and _alone(every)))
    usual = [ObjectRow.nowhere(every[0].identity)] if alone else []
    values = (row.values(each, [*further]) for row in recorded for each in row.objects or usual)
    return (*COLUMNS, *further), values


def _alone(objects: Sequence[ObjectRow]) -> bool:
    """Return whether there is one object, and it was followed."""
    followed = any(each.distance is not None or each.ellipse.theta != 0 for each in objects)
    identities = {each.identity for each in objects}
    return followed and len(identities) == 1 and ANONYMOUS not in identities


def write(form: Form, recorded: Recording) -> Iterator[bytes]:
    """Yield a line for each row, after the titles of CSV."""
    columns, rows = table_of(recorded)
    for text in head(form, columns):
        yield f"{text}\n".encode()
    for values in rows:
        yield f"{line(form, columns, values)}\n".encode()


def read(path: Path, facts: FilmFacts) -> Recording:
    """Return the objects of rows of motes in CSV or JSON Lines."""
    table = read_track(path)
    names = table.dtype.names or ()
    return recording_of_rows(
        (dict(zip(names, row, strict=True)) for row in table.tolist()), names, facts
    )


def read_journal(path: Path, facts: FilmFacts) -> Recording:
    """Return the rows of a document whose run was killed; they hold all that is known of it."""
    del facts
    found = recording_of_journal(path)
    for row in found:
        with at(f"frame {row.frame}"):
            for each in row.objects:
                sound(each)
    return found


def recording_of_journal(path: Path) -> Recording:
    """Return the rows in a journal, without a last line that was cut off.

    Raises
    ------
    SourceError
        If the file cannot be read, is no journal, or a line is damaged.
    """
    decoder = msgspec.json.Decoder(FrameRow)
    frames, left_out = list[FrameRow](), list[str]()
    first: Header | None = None
    try:
        with path.open("rb") as file:
            first = msgspec.json.decode(file.readline(), type=Header)
            for text in file:
                if text.endswith(b"\n"):
                    frames.append(decoder.decode(text))
                else:
                    left_out.append("the last line, which is cut off")
    except OSError as error:
        raise SourceError(f"{path} cannot be read: {error.strerror}; check the name.") from None
    except (msgspec.DecodeError, UnicodeDecodeError, RecursionError):
        if first is not None:
            raise SourceError(
                f"{path} is damaged in line {len(frames) + 2}; remove the line, and try again."
            ) from None
        raise SourceError(
            f"{path} does not hold the rows of a document; they are in a file NAME{ENDING}."
        ) from None
    return Recording(first, frames, left_out)


def recording_of_rows(
    rows: Iterable[Mapping[str, Any]], names: Sequence[str], facts: FilmFacts
) -> Recording:
    """Return the objects of rows, each with a value for each name; NaN, None and "" are empty.

    Raises
    ------
    FormatError
        If a value is missing or damaged, or they are rows of several cameras.
    """
    if CAMERA in names:
        raise FormatError("its rows are of several cameras; keep those of one, without the column")
    place = ELLIPSE if "x" in names else BOX
    times: dict[int, float | None] = {}
    further = [name for name in KNOWN[len(COLUMNS) :] if name in names]
    others = [name for name in names if name not in KNOWN]
    left_out = [f"the columns {', '.join(others)[:80]}"] if others else []
    objects, searched = [], []
    turned = set[int]()
    for number, row in enumerate(rows, start=1):
        known = {name: value for name, value in row.items() if value not in ("", None)}
        known = {name: value for name, value in known.items() if value == value}  # NaN is empty
        with at(f"row {number}"):
            frame = whole(str(known["frame"]))
            times[frame] = float(known["time"]) if "time" in names else None
            each = _object(known, place, further, rated="confidence" in names)
            if each is None:
                searched.append((frame, _identity(known)))
            else:
                if each.identity not in turned:
                    check_angle(each.ellipse.theta)
                    turned.add(each.identity)
                objects.append((frame, each))
    told = facts.run or range(0)
    return recording_of(facts, objects, times, left_out=left_out, searched=searched, told=told)


def _object(
    row: Mapping[str, Any], place: Sequence[str], further: Sequence[str], *, rated: bool
) -> ObjectRow | None:
    """Return the object of a row; None where it has no place, as one that is searched for."""
    status = Status(row.get("status", Status.TRACKING))
    more = {name: row[name] for name in further if name in row}
    for name, value in more.items():
        if not isinstance(value, str | int | float):
            raise ValueError(f"{name} is not a number")
        if isinstance(value, float) and not math.isfinite(value):
            raise ValueError(f"{name} is {value}")
    absent = status is Status.ABSENT
    if not absent and status not in SHOWN and not any(name in row for name in place):
        return None
    numbers = [math.nan if absent else float(row[name]) for name in place]
    behind = row.get("occluded_by")
    sure = row["confidence"] if rated and status is Status.TRACKING else math.nan if absent else 1.0
    found = ObjectRow(
        _identity(row),
        Ellipse(*numbers) if place is ELLIPSE else Ellipse.from_box(numbers),
        float(row.get("confidence", sure)),
        status,
        None if behind is None else whole(str(behind)),
        row.get("label"),
        more=more,
        distance=_number(row, "distance"),
        effective_sample_size=_number(row, "effective_sample_size"),
        bounds=Box(*(float(row[name]) for name in BOX)) if "left" in row else None,
    )
    return found if absent else sound(found)


def _identity(row: Mapping[str, Any]) -> int:
    identity = whole(str(row.get("id", 1)))
    if identity < ANONYMOUS:
        raise ValueError(f"{identity} is no identity; they count from 0, and -1 is none")
    return identity


def _number(row: Mapping[str, Any], name: str) -> float | None:
    return float(row[name]) if name in row else None
