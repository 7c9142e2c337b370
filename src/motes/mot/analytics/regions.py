"""Lines that objects cross and zones that they enter and leave, and on which side a point lies."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Sequence
from itertools import chain, combinations
from typing import Annotated, Literal

import numpy as np
from msgspec import Meta
from msgspec.structs import replace

from motes.core.config import Config
from motes.core.errors import ConfigError
from motes.core.geometry import as_text, clipped
from motes.mot.analytics.ground_plane import Ground, Number, Point

STROKE = 0.12
"""Length of the stroke that shows a line's first direction, as a share of the line."""
NEAR = 1.0
"""Pixels; a side of a zone that is nearer to the edge of the picture lies on it."""
AT_EDGE = 0.02
"""A line that would leave the picture within this share of its smaller side ends at its edge."""
SETTLED = 0.4
"""Seconds after which a crossing, an entry or an exit counts, unless the object comes back."""


class Line(Config, frozen=True):
    """A line whose crossings are counted.

    An object crosses it to the left or to the right, as seen from the first point towards the
    second: in or out.
    """

    points: tuple[Number, Number, Number, Number]
    """Its two ends: x1, y1, x2, y2, in pixels."""
    name: str = ""
    """Its name in events; by default its number."""
    label: tuple[str, str] = ("in", "out")
    """Names of its two directions in events, for crossings to the left and to the right."""

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.label[0] == self.label[1] or not all(self.label):
            raise ConfigError(f"The label of a line is two different names; got {self.label}.")
        if self.points[:2] == self.points[2:]:
            raise ConfigError(f"A line needs two different points; got {as_text(self.points)}.")

    @property
    def stroke(self) -> tuple[Point, Point]:
        """A stroke from the line's middle to its left: where an object goes that crosses it so."""
        x1, y1, x2, y2 = self.points
        middle, share = ((x1 + x2) / 2, (y1 + y2) / 2), STROKE
        return middle, (middle[0] + share * (y2 - y1), middle[1] - share * (x2 - x1))

    def gap(self, point: Point) -> float:
        """Return the distance of a point from the line between its ends."""
        return _gap(self.points[:2], self.points[2:], point)

    def beyond(self, size: tuple[int, int]) -> Line:
        """Return the line with ends at the edge of a picture moved out of it by its sides.

        The feet of an object that this edge cuts are beyond it.
        """
        first, second = self.points[:2], self.points[2:]
        ends = _moved_out(second, first, size) + _moved_out(first, second, size)
        return replace(self, points=ends)


class Zone(Config, frozen=True):
    """A polygon whose entries and exits are counted."""

    points: Annotated[tuple[Number, ...], Meta(min_length=6)]
    """Its corners: x1, y1, x2, y2, x3, y3, ..., in pixels."""
    name: str = ""
    """Its name in events; by default its number."""
    dwell: Annotated[float, Meta(ge=SETTLED, le=1e9)] | None = None
    """An object that is inside for this many seconds causes the event `stays`; by default none
    does."""

    def __post_init__(self) -> None:
        super().__post_init__()
        if len(self.points) % 2:
            raise ConfigError(
                f"A zone has an x and a y for each corner; got {as_text(self.points)}."
            )

    @property
    def sides(self) -> list[tuple[Point, Point]]:
        """The ends of its sides."""
        corners = [*zip(self.points[::2], self.points[1::2], strict=True)]
        return [*zip(corners, corners[1:] + corners[:1], strict=True)]

    def holds(self, point: Point) -> bool:
        """Return whether a point lies in the zone: a ray from it crosses an odd number of sides."""
        (x, y), inside = point, False
        for (x1, y1), (x2, y2) in self.sides:
            if (y1 > y) != (y2 > y) and x < x1 + (y - y1) * (x2 - x1) / (y2 - y1):
                inside = not inside
        return inside

    def depth(self, point: Point) -> float:
        """Return the distance of a point from the edge of the zone."""
        return min(_gap(start, end, point) for start, end in self.sides)

    @property
    def reach(self) -> float:
        """A depth that a point in the middle has: half the area by the length of the edge."""
        twice = sum(a * d - b * c for (a, b), (c, d) in self.sides)
        return abs(twice) / 4 / sum(math.dist(*side) for side in self.sides)

    def beyond(self, size: tuple[int, int]) -> Zone:
        """Return the zone with sides on the edge of a picture moved out of it by its size.

        An object that this edge cuts may go on beyond it.
        """
        corners = list[Point]()
        for side in self.sides:
            corners.append(side[0])
            for axis, length in enumerate(size):
                low, high = sorted(corner[axis] for corner in side)
                if high <= NEAR or low >= length - 1 - NEAR:
                    far = -length if high <= NEAR else length
                    corners += [(x + far * (axis == 0), y + far * (axis == 1)) for x, y in side]
                    break
        return replace(self, points=tuple(chain.from_iterable(corners)))


class Regions(Config, frozen=True):
    """The lines and zones of counting, and the ground. In TOML: [[line]], [[zone]] and [ground]."""

    line: tuple[Line, ...] = ()
    """The lines."""
    zone: tuple[Zone, ...] = ()
    """The zones."""
    ground: Ground | None = None
    """The ground plane, for speeds in metres per second."""

    def __post_init__(self) -> None:
        super().__post_init__()
        names = Counter([*self._names("line", self.line), *self._names("zone", self.zone)])
        if len(names) < names.total():
            twice = names.most_common(1)[0][0]
            raise ConfigError(f"Two lines or zones have the name {twice!r}; rename one of them.")
        for name, zone in self.zones.items():
            for (a, b), (c, d) in combinations(zone.sides, 2):
                if _side(a, b, c) * _side(a, b, d) < 0 and _side(c, d, a) * _side(c, d, b) < 0:
                    raise ConfigError(f"{name} crosses itself; give its corners in order.")
            if abs(sum(a * d - b * c for (a, b), (c, d) in zone.sides)) < 2:  # less than a pixel
                raise ConfigError(
                    f"{name} has no area; give corners in pixels that are not on one line."
                )

    def check(self, width: int, height: int) -> None:
        """Raise a ConfigError if a line or a zone lies outside of a picture."""
        places: dict[str, Line | Zone] = {**self.lines, **self.zones}
        for name, place in places.items():
            corners = np.reshape(place.points, (-1, 2))
            if np.max(corners) <= 1 or not len(clipped(corners, width - 1, height - 1)):
                raise ConfigError(
                    f"{name} ({as_text(place.points)}) lies outside of the picture, {width}x"
                    f"{height} pixels, or is given in shares of its sides; give pixels in it."
                )

    @property
    def lines(self) -> dict[str, Line]:
        """Lines by name; one without a name has its number, from 1."""
        return dict(zip(self._names("line", self.line), self.line, strict=True))

    @property
    def zones(self) -> dict[str, Zone]:
        """Zones by name, likewise."""
        return dict(zip(self._names("zone", self.zone), self.zone, strict=True))

    @property
    def totals(self) -> list[str]:
        """What passes are counted as (`Event.total`): a name for each side of a line, and zone."""
        sides = [f"{name} {label}" for name, line in self.lines.items() for label in line.label]
        return sides + [f"{name} {what}" for name in self.zones for what in ("enters", "leaves")]

    @staticmethod
    def _names(kind: str, places: Sequence[Line | Zone]) -> list[str]:
        return [each.name or f"{kind} {i}" for i, each in enumerate(places, start=1)]


def _moved_out(start: Point, end: Point, size: tuple[int, int]) -> Point:
    """Return the end of a line, moved on out of a picture if it is at its edge."""

    def further(length: float) -> Point:
        share = length / math.dist(start, end)
        x, y = (b + share * (b - a) for a, b in zip(start, end, strict=True))
        return x, y

    out = further(AT_EDGE * min(size))
    inside = all(0 <= at <= side - 1 for at, side in zip(out, size, strict=True))
    return end if inside else further(sum(size))


def crossing(
    line: tuple[float, float, float, float], before: Point, after: Point
) -> Literal["left", "right"] | None:
    """Return the side to which a step from one point to another crosses a line, or None.

    A step that ends on the line does not cross it; the next step that leaves the line does.
    """
    start, end = line[:2], line[2:]
    here, there = _side(start, end, before), _side(start, end, after)
    if (here > 0) == (there > 0):
        return None
    if (_side(before, after, start) > 0) == (_side(before, after, end) > 0):
        return None  # it passes beside the line's end
    return "right" if there > 0 else "left"


def meeting_point(line: tuple[float, float, float, float], before: Point, after: Point) -> Point:
    """Return where a step from one point to another, that crosses a line, meets it."""
    here, there = (_side(line[:2], line[2:], point) for point in (before, after))
    share = here / (here - there)
    return tuple(a + share * (b - a) for a, b in zip(before, after, strict=True))  # type: ignore[return-value]


def _side(start: Point, end: Point, point: Point) -> float:
    """Return the side of a line on which a point lies: above 0 on the right, seen along it."""
    return (end[0] - start[0]) * (point[1] - start[1]) - (end[1] - start[1]) * (point[0] - start[0])


def distance(line: tuple[float, float, float, float], point: Point) -> float:
    """Return the distance of a point from a line without ends."""
    return abs(_side(line[:2], line[2:], point)) / math.dist(line[:2], line[2:])


def _gap(start: Point, end: Point, point: Point) -> float:
    """Return the distance of a point from a segment."""
    along = end[0] - start[0], end[1] - start[1]
    length = math.hypot(*along) or 1.0
    unit = along[0] / length, along[1] / length  # squares of numbers that are huge overflow
    way = unit[0] * (point[0] - start[0]) + unit[1] * (point[1] - start[1])
    way = min(max(way, 0.0), length)
    return math.dist(point, (start[0] + way * unit[0], start[1] + way * unit[1]))
