"""Rows of motes: CSV and JSON Lines, with the columns of `motes.rows.schema`.

Rows of others may lack the ellipse, if they have a box, and all else but the frame.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

import msgspec

from motes.core.errors import ConfigError, FormatError, SourceError
from motes.core.geometry import check_angle
from motes.core.track import BOX, COLUMNS, ELLIPSE, Status, Track
from motes.formats.recording import ANONYMOUS, FilmFacts, Recording, sound, stride_of
from motes.formats.text import at, whole
from motes.formats.visibility import SHOWN
from motes.rows.reader import read_track
from motes.rows.schema import CAMERA, ENDING, KNOWN, Form, FrameRow, Header, further, head, line


def table_of(recorded: Recording) -> tuple[Sequence[str], Iterator[Sequence[Any]]]:
    """Return the columns and the rows of a recording.

    A frame in which its file shows nothing has a row too, as else it would be one at which nobody
    has looked: the first object is absent there, or searched for. Boxes without identities, and
    the rows of a scene's run, whose other frames are known, are silent on it.
    """
    every = [each for row in recorded for each in row.objects]
    held = dict.fromkeys(name for each in every for name in further(each))
    more = sorted(held, key=lambda name: KNOWN.index(name) if name in KNOWN else len(KNOWN))
    first = next((each.identity for each in every if each.identity != ANONYMOUS), None)

    def objects(row: FrameRow) -> Sequence[Track]:
        if row.objects or first is None or recorded.told:
            return row.objects
        status = Status.SEARCHING if row.searched else Status.ABSENT
        return [Track.nowhere(row.frame, row.time, status, first)]

    values = (row.values(each, more) for row in recorded for each in objects(row))
    return (*COLUMNS, *more), values


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
    """Return the rows of a document whose run was killed, of a film of a length that is known."""
    found = dataclasses.replace(recording_of_journal(path), length=facts.frames or 0)
    for row in found:
        with at(f"frame {row.frame}"):
            for each in row.objects:
                sound(each)
    return found


def recording_of_journal(path: Path) -> Recording:
    """Return the rows in a journal, without a last line that was cut off.

    Raises a SourceError if the file cannot be read, is no journal, or a line is damaged.
    """
    frames, left_out = list[FrameRow](), list[str]()
    first: Header | None = None
    try:
        with path.open("rb") as file:
            first = msgspec.json.decode(file.readline(), type=Header)
            for text in file:
                if text.endswith(b"\n"):
                    frames.append(FrameRow.from_dict(msgspec.json.decode(text)))
                else:
                    left_out.append("the last line, which is cut off")
    except OSError as error:
        raise SourceError(f"{path} cannot be read: {error.strerror}; check the name.") from None
    except (LookupError, TypeError, ValueError, OverflowError, ConfigError, RecursionError):
        if first is not None:
            raise SourceError(
                f"{path} is damaged in line {len(frames) + 2}, or of another version of motes; "
                f"remove the line from a copy, and try again."
            ) from None
        raise SourceError(
            f"{path} does not hold the rows of a document of this version of motes; they are in a "
            f"file NAME{ENDING}."
        ) from None
    stride = stride_of([row.frame for row in frames])
    return Recording(first, frames, left_out, stride=stride, listed=True)


def recording_of_rows(
    rows: Iterable[Mapping[str, Any]], names: Sequence[str], facts: FilmFacts
) -> Recording:
    """Return the objects of rows, each with a value for each name; NaN, None and "" are empty.

    Raises a FormatError if a value is missing or damaged, or they are rows of several cameras.
    """
    if CAMERA in names:
        raise FormatError(
            "its rows are of several cameras; copy the lines of one into a file, without the "
            f"column {CAMERA}"
        )
    place = ELLIPSE if "x" in names else BOX
    times: dict[int, float | None] = {}
    apart = set(ELLIPSE) - set(place)  # such as an angle beside a box
    others = [name for name in names if name not in KNOWN or name in apart]
    left_out = [f"the columns {', '.join(others)[:80]}"] if others else []
    objects, searched = [], []
    angles: dict[int, float] = {}
    for number, row in enumerate(rows, start=1):
        known = {name: value for name, value in row.items() if value not in ("", None)}
        known = {name: value for name, value in known.items() if value == value}  # NaN is empty
        with at(f"row {number}"):
            frame = whole(str(known["frame"]))
            times[frame] = float(known["time"]) if "time" in names else None
            each = _object(known, place, rated="confidence" in names)
            if each is None:
                searched.append((frame, _identity(known)))
            else:
                last, theta = angles.get(each.identity), each.ellipse.theta
                if last is None:
                    check_angle(theta)
                elif "distance" not in names and abs(theta - last) > 2 * math.pi:  # not of motes
                    raise ValueError(
                        f"theta goes from {last:g} to {theta:g}; it is in radians, and a turn is "
                        f"{2 * math.pi:.2f}"
                    )
                angles[each.identity] = theta
                objects.append(each)
    if "id" not in names and len({each.frame for each in objects}) < len(objects):
        raise FormatError(
            "it has several objects in a frame, and no column id; add one, of -1 if it is not "
            "known which is which"
        )
    told = facts.run or range(0)
    found = Recording.of(facts, objects, times, left_out=left_out, searched=searched, told=told)
    stride = facts.run.step if facts.run is not None else stride_of([row.frame for row in found])
    return dataclasses.replace(found, stride=stride)


def _object(row: Mapping[str, Any], place: Sequence[str], *, rated: bool) -> Track | None:
    """Return the object of a row; None where it has no place, as one that is searched for."""
    if (given := row.get("status", Status.TRACKING)) not in [*Status]:
        raise ValueError(f"status is {given!r}; it is one of {', '.join(Status)}")
    status = Status(given)
    for name in KNOWN[len(COLUMNS) :]:
        value = row.get(name, 0)
        if not isinstance(value, str | int | float):
            raise ValueError(f"{name} is not a number")
        if isinstance(value, float) and not math.isfinite(value):
            raise ValueError(f"{name} is {value}")
    absent = status is Status.ABSENT
    if not absent and status not in SHOWN and not any(name in row for name in place):
        return None
    needed = [] if absent else [*place, *["confidence"] * (rated and status is Status.TRACKING)]
    known = {name: row[name] for name in needed}
    known |= {name: row[name] for name in KNOWN if name in row}
    known |= {"frame": whole(str(row["frame"])), "id": _identity(row)}
    if "occluded_by" in known:
        known["occluded_by"] = whole(str(known["occluded_by"]))
    if absent:
        return Track.from_dict(known | dict.fromkeys((*BOX, *ELLIPSE)))
    return sound(Track.from_dict({"confidence": 1.0} | known))


def _identity(row: Mapping[str, Any]) -> int:
    identity = whole(str(row.get("id", 1)))
    if identity < ANONYMOUS:
        raise ValueError(f"{identity} is no identity; they count from 0, and -1 is none")
    return identity
