"""DeepLabCut's CSV, which `movement` and other tools for the behavior of animals read.

Each object has three points: its center, and the ends of its ellipse's half-axes a and b. So the
whole ellipse is there, and tools have the object's orientation. The likelihood is the confidence.
https://deeplabcut.github.io/DeepLabCut/docs/standardDeepLabCut_UserGuide.html
"""

from __future__ import annotations

import csv
import io
import math
from collections.abc import Iterator
from pathlib import Path

from motes.core.errors import FormatError
from motes.core.files import check_ended
from motes.core.geometry import Ellipse
from motes.core.track import Status
from motes.formats.recording import ANONYMOUS, FilmFacts, Recorded, Recording, recording_of, sound
from motes.formats.text import at, number, read_text, whole
from motes.formats.visibility import visible
from motes.rows.journal import ObjectRow

POINTS = ("center", "axis_a", "axis_b")
NAME = "object_"
"""Prefix of the name of an individual; the identity follows."""
VALUES = ("x", "y", "likelihood")
TITLES = ("scorer", "individuals", "bodyparts", "coords")
UNKNOWN = ("", "nan")
"""Fields of points that are not known."""


def write(recorded: Recorded) -> Iterator[bytes]:
    """Yield four rows of titles (three if there is one object), then a row for each frame."""
    identities = sorted({each.identity for row in recorded for each in visible(row)})
    if ANONYMOUS in identities:
        raise FormatError("DeepLabCut holds individuals, and there are boxes without identities.")
    columns = [
        (identity, point, value) for identity in identities for point in POINTS for value in VALUES
    ]
    titles = [("scorer", ["motes"] * len(columns))]
    if len(identities) > 1:
        titles.append(("individuals", [f"{NAME}{each}" for each, _, _ in columns]))
    titles.append(("bodyparts", [point for _, point, _ in columns]))
    titles.append(("coords", [value for _, _, value in columns]))
    for title, values in titles:
        yield ",".join([title, *values]).encode() + b"\n"
    for row in recorded:
        here = {each.identity: each for each in visible(row)}
        fields = [field for identity in identities for field in _fields(here.get(identity))]
        yield ",".join([str(row.frame), *fields]).encode() + b"\n"


def _fields(each: ObjectRow | None) -> list[str]:
    if each is None:
        return [""] * len(POINTS) * len(VALUES)
    x, y, a, b, theta = each.ellipse
    cos, sin = math.cos(theta), math.sin(theta)
    points = (x, y), (x + a * cos, y + a * sin), (x - b * sin, y + b * cos)
    return [
        field for u, v in points for field in (f"{u:.3f}", f"{v:.3f}", f"{each.confidence:.5f}")
    ]


def read(path: Path, facts: FilmFacts) -> Recording:
    """Return the objects of a file that has the points of `write`.

    Raises
    ------
    FormatError
        If it has other points: a place alone has no size.
    """
    text = read_text(path)
    check_ended(text)
    try:
        lines = list(csv.reader(io.StringIO(text)))
    except csv.Error as error:
        raise FormatError(f"it is no table: {error}") from None
    titles = {line[0]: line[1:] for line in lines[:4] if line and line[0] in TITLES}
    points = titles.get("bodyparts", [])
    if not set(POINTS) <= set(points):
        raise FormatError(f"it has no points {', '.join(POINTS)}, and others have no size")
    individuals = titles.get("individuals", [f"{NAME}1"] * len(points))
    names = {name: _identity(name, i) for i, name in enumerate(dict.fromkeys(individuals), 1)}
    coordinates = titles.get("coords", [])
    if not len(individuals) == len(points) == len(coordinates):
        raise FormatError("its rows of titles have different lengths, or one is missing")
    columns = list(zip(individuals, points, coordinates, strict=True))
    if len(set(columns)) < len(columns):
        raise FormatError("two of its columns have the same titles")
    objects, times = [], dict[int, None]()
    for place, line in enumerate(lines[len(titles) :], start=len(titles) + 1):
        with at(f"line {place}"):
            if len(line) != len(columns) + 1:
                raise ValueError(f"it has {len(line)} fields in place of {len(columns) + 1}")
            frame = whole(line[0])
            if frame in times:
                raise ValueError(f"frame {frame} is there twice")
            times[frame] = None
            values = dict(zip(columns, line[1:], strict=True))
            for name, identity in names.items():
                row = _row(values, name, identity)
                objects += [] if row is None else [(frame, row)]
    others = [point for point in dict.fromkeys(points) if point not in POINTS]
    left_out = [f"the points {', '.join(others)[:80]}, which have no size"] if others else []
    return recording_of(facts, objects, times, left_out=left_out)


def _row(values: dict[tuple[str, str, str], str], name: str, identity: int) -> ObjectRow | None:
    """Return an individual in a frame; None where none of its points is known."""
    if any((name, point, value) not in values for point in POINTS for value in VALUES):
        raise ValueError(f"{name} lacks a column")
    place = [values[name, point, value] for point in POINTS for value in VALUES[:2]]
    if all(field.lower() in UNKNOWN for field in place):
        return None
    likelihood = number(values[name, POINTS[0], VALUES[2]])
    ellipse = _ellipse([number(field) for field in place])
    return sound(ObjectRow(identity, ellipse, likelihood, Status.TRACKING))


def _identity(name: str, place: int) -> int:
    """Return the number in the name that `write` gives, or else the place among individuals."""
    return int(name.removeprefix(NAME)) if name.removeprefix(NAME).isdigit() else place


def _ellipse(place: list[float]) -> Ellipse:
    x, y, ax, ay, bx, by = place
    theta = math.atan2(ay - y, ax - x)
    return Ellipse(x, y, math.hypot(ax - x, ay - y), math.hypot(bx - x, by - y), theta)
