"""The output of a tracker on a sequence (a trace), frame by frame, in memory and in a file."""

from __future__ import annotations

import csv
import io
import math
from collections.abc import Iterable
from dataclasses import dataclass, fields
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from motes import Ellipse, FormatError
from motes.core import Floats, write_whole, writing
from motes_lab.adapters.sot import LARGEST, Position


@dataclass(frozen=True, slots=True, eq=False)
class TrackerOutput:
    """The output of a tracker in one pass, from its start to the end of the sequence."""

    frames: NDArray[np.int64]
    """(n,), index of each frame."""
    ellipses: Floats
    """(n, 5); upright ones if the tracker gives boxes. A frame without output repeats the last
    output, and has NaN before the first."""
    confidence: Floats
    """(n,), NaN if the tracker gives none."""
    lost: NDArray[np.bool_]
    """(n,), whether the tracker reports that it has lost the target."""
    seconds: Floats
    """(n,), time inside the tracker; the first row's is that of its start."""
    covariances: Floats
    """(n, 3), of the ellipses' centers: xx, xy, yy; NaN if the tracker gives none."""


class Row(NamedTuple):
    """One frame of a trace."""

    frame: int
    ellipse: Ellipse
    confidence: float
    lost: bool
    seconds: float
    covariance: Position


NOWHERE = Ellipse(*[float("nan")] * 5)


KINDS = (np.int64, np.float64, np.float64, np.bool_, np.float64, np.float64)


def trace_of(rows: list[Row]) -> TrackerOutput:
    """Return rows as arrays."""
    columns = zip(zip(*rows, strict=True), KINDS, strict=True)
    return TrackerOutput(*(np.array(column, kind) for column, kind in columns))


COLUMNS = (
    *("frame", *Ellipse._fields, "confidence", "lost", "seconds", "event"),
    *("xx", "xy", "yy"),
)
"""The columns of a trace's file; `lost` is 0 or 1, NaN an empty field. `event` is `started` in the
first row, and `tracked` in all others."""


def save_trace(path: str | Path, trace: TrackerOutput) -> None:
    """Write a trace as CSV with the `COLUMNS`, complete or not at all; reading restores it exactly.

    Raises
    ------
    FormatError
        If it cannot be written.
    """
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(COLUMNS)
    columns = (getattr(trace, each.name).tolist() for each in fields(trace))
    for index, row in enumerate(zip(*columns, strict=True)):
        frame, ellipse, confidence, lost, seconds, covariance = row
        numbers = _fields((*ellipse, confidence))
        rest = ["tracked" if index else "started", *_fields(covariance)]
        writer.writerow([frame, *numbers, int(lost), *_fields([seconds]), *rest])
    path = Path(path)
    with writing(path):
        path.parent.mkdir(parents=True, exist_ok=True)
        write_whole(path, text.getvalue().encode())


def _fields(values: Iterable[float]) -> list[str]:
    return ["" if value != value else repr(value) for value in values]


def load_trace(path: str | Path) -> TrackerOutput:
    """Read a trace that `save_trace` wrote.

    Raises
    ------
    FormatError
        If the file cannot be read or is not a trace.
    """
    try:
        head, *lines = csv.reader(io.StringIO(Path(path).read_text(encoding="utf-8")))
        if tuple(head) != COLUMNS:
            raise ValueError("it has other columns")
        rows: list[Row] = []
        for place, line in enumerate(lines, 2):
            rows.append(_row(line, place))
            if rows[-1].frame != rows[0].frame + len(rows) - 1:
                raise ValueError(f"line {place}: its frames do not follow each other")
            if line[COLUMNS.index("event")] != ("started" if len(rows) == 1 else "tracked"):
                raise ValueError(f"line {place}: only its first frame is a start")
        if not rows or not 0 <= rows[0].frame <= LARGEST:
            raise ValueError("its first frame is missing")
        return trace_of(rows)
    except OSError as error:
        raise FormatError(f"{path} cannot be read: {error.strerror}.") from None
    except (ValueError, csv.Error) as error:
        raise FormatError(f"{path} is not a track of an evaluation ({error}).") from None


def _row(fields: list[str], line: int) -> Row:
    """Return a row of a trace; raise a ValueError with the line number if it is not valid."""
    try:
        if len(fields) != len(COLUMNS):
            raise ValueError("it has more or fewer columns than the first one")
        return _parse_fields(*fields)
    except ValueError as error:
        raise ValueError(f"line {line}: {error}") from None


def _parse_fields(
    frame: str, x: str, y: str, a: str, b: str, theta: str,
    confidence: str, lost: str, seconds: str, _: str, xx: str, xy: str, yy: str,
) -> Row:  # fmt: skip
    ellipse = Ellipse(*map(number, (x, y, a, b, theta)))
    sure, time = number(confidence), duration(seconds)
    if min(ellipse.a, ellipse.b) < 1 / LARGEST:
        raise ValueError(f"the ellipse of frame {frame} has no area")
    if not (math.isnan(sure) or 0 <= round(sure, 9) <= 1):
        raise ValueError(f"the confidence of frame {frame} is {sure:g}")
    position = number(xx), number(xy), number(yy)
    return Row(int(frame), ellipse, sure, lost == "1", time, position)


def number(field: str) -> float:
    """Return the number in a field of a track, NaN if it is empty.

    Raises
    ------
    ValueError
        If it is not a number, or out of bounds.
    """
    value = float(field) if field else math.nan
    if abs(value) > LARGEST**2:  # a covariance may be as large as the square
        raise ValueError(f"{field} is out of bounds")
    return value


def duration(field: str) -> float:
    """Return the seconds in a field of a track, NaN if it is empty.

    Raises
    ------
    ValueError
        If it is not a duration.
    """
    seconds = number(field)
    if seconds < 0 or 0 < seconds < 1 / LARGEST:
        raise ValueError(f"a frame cannot take {field} s")
    return seconds
