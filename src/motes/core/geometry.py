"""Ellipses, boxes and how much they overlap.

Pixels are (x, y), x to the right, y down, pixel centers at integer coordinates. A box
(x, y, width, height) covers the pixels x … x + width - 1, that is, the area from x - 1/2 to
x + width - 1/2. Angles run from the +x axis towards the +y axis, clockwise as seen on screen.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence, Set
from typing import Any, NamedTuple, Self

import numpy as np
from numpy.typing import ArrayLike

from motes.core.errors import ConfigError
from motes.core.types import Floats, Numbers

FARTHEST = 1e15
"""Largest coordinate or size that files may hold. Whole numbers up to it are exact."""

CUT = 2.0
"""Pixels; a box that is nearer to the border may be cut off by it."""


class Box(NamedTuple):
    """A box whose sides are parallel to those of the picture."""

    x: float
    y: float
    """The first column and the first row of pixels; they count from 0, to the right and
    downwards."""
    width: float
    height: float
    """Numbers of columns and of rows."""

    @property
    def foot(self) -> tuple[float, float]:
        """The middle of its lower edge, where an object stands on the ground."""
        return self.x + (self.width - 1) / 2, self.y + self.height - 1

    def is_cut(self, size: tuple[int, int] | None) -> bool:
        """Return whether the edge of a picture, of a width and height, may cut it."""
        return size is not None and self.room(*size) < CUT

    def room(self, width: int, height: int) -> float:
        """Return its distance from the border of a picture; below 0 if it reaches beyond."""
        right, low = self.x + self.width, self.y + self.height
        return min(self.x, self.y, width - right, height - low)


class Ellipse(NamedTuple):
    """An ellipse in a picture, upright or turned."""

    x: float
    y: float
    """The center in pixels. Centers of pixels have whole numbers, from 0."""
    a: float
    b: float
    """The half-axes in pixels."""
    theta: float = 0.0
    """Angle of a in radians, from the x axis to the y axis: clockwise on the screen."""

    @classmethod
    def from_box(cls, box: Sequence[float]) -> Self:
        """Return the upright ellipse inscribed in a box (x, y, width, height)."""
        x, y, width, height = box
        return cls(x + (width - 1) / 2, y + (height - 1) / 2, width / 2, height / 2)

    @property
    def box(self) -> Box:
        """The smallest axis-parallel box around the ellipse."""
        cos, sin = math.cos(self.theta), math.sin(self.theta)
        half_width = math.hypot(self.a * cos, self.b * sin)
        half_height = math.hypot(self.a * sin, self.b * cos)
        return Box(
            self.x - half_width + 0.5, self.y - half_height + 0.5, 2 * half_width, 2 * half_height
        )

    def turned_near(self, angle: float) -> Self:
        """Return the same ellipse with the theta that is nearest to an angle, by half turns."""
        if abs(self.theta - angle) <= math.pi / 2 or not math.isfinite(self.theta - angle):
            return self
        return self._replace(theta=angle + math.remainder(self.theta - angle, math.pi))

    @property
    def area(self) -> float:
        """The area in square pixels."""
        return math.pi * self.a * self.b

    @property
    def side(self) -> float:
        """The mean side of the ellipse's box, in pixels: the geometric mean of both axes."""
        return 2 * math.sqrt(self.a * self.b)

    def inner(self, x: Any, y: Any) -> tuple[Any, Any]:
        """Return offsets from the center along a and along b, in units of these half-axes."""
        cos, sin = math.cos(self.theta), math.sin(self.theta)
        return (x * cos + y * sin) / self.a, (y * cos - x * sin) / self.b

    def polygon(self, corners: int = 48) -> Floats:
        """Return (corners, 2) points on the outline, in order."""
        t = np.linspace(0, 2 * math.pi, corners, endpoint=False)
        u, v = self.a * np.cos(t), self.b * np.sin(t)
        cos, sin = math.cos(self.theta), math.sin(self.theta)
        return np.stack([self.x + u * cos - v * sin, self.y + u * sin + v * cos], axis=1)


class Angled(Ellipse):
    """An ellipse that was given as one: its angle is asked for, also where that is 0."""


def clipped(corners: Floats, width: float, height: float) -> Floats:
    """Return the part of a convex polygon between 0, 0 and width, height.

    Corners (n, 2) are in order, in the argument and in the result. The result is empty if no part
    lies there. After Sutherland and Hodgman, Reentrant polygon clipping, 1974.
    """
    if len(corners) and (corners.min(0) >= 0).all() and (corners.max(0) <= (width, height)).all():
        return corners  # the usual case, and fast
    for axis, sign, limit in ((0, 1, 0.0), (0, -1, width), (1, 1, 0.0), (1, -1, height)):
        depth = sign * (corners[:, axis] - limit)
        following = np.roll(depth, -1)
        crosses = (depth < 0) != (following < 0)
        share = np.divide(depth, depth - following, out=np.zeros_like(depth), where=crosses)
        cuts = corners + share[:, None] * (np.roll(corners, -1, axis=0) - corners)
        cuts[:, axis] = limit  # it is already, except for rounding
        corners = np.stack([corners, cuts], axis=1)[np.stack([depth >= 0, crosses], axis=1)]
    return corners


def area(corners: Floats) -> float:
    """Return the area of a polygon of corners (n, 2) in order."""
    x, y = corners.T
    twice = x[:-1] @ y[1:] - y[:-1] @ x[1:] + x[-1:] @ y[:1] - y[-1:] @ x[:1]
    return float(abs(twice) / 2)


WITHOUT_ORDER = (str, bytes, bytearray, Set, Mapping)
"""Types that hold no numbers in order."""


def in_order(numbers: Any) -> Any:
    """Return numbers that have an order; raise a TypeError for a set, a mapping, text or bytes."""
    if isinstance(numbers, WITHOUT_ORDER):
        raise TypeError(f"{type(numbers).__name__} has no numbers in order")
    return numbers


def as_ellipse(region: Numbers) -> Ellipse:
    """Return a region, an `Ellipse`, (x, y, a, b, theta) or a box (x, y, w, h), as an ellipse.

    Raises a ConfigError if the region does not have four or five finite numbers or has no area, or
    is absurdly large or small.
    """
    try:
        values = [float(value) for value in in_order(region)]
    except (TypeError, ValueError, OverflowError) as error:
        raise ConfigError(
            f"A region is x,y,width,height or x,y,a,b,theta; got {repr(region)[:80]}."
        ) from error
    if len(values) not in (4, 5):
        raise ConfigError(
            f"A region has 4 numbers (box x,y,width,height) or 5 (ellipse x,y,a,b,theta); "
            f"got {len(values)}."
        )
    if not all(abs(value) <= FARTHEST for value in values):
        raise ConfigError(
            f"The region {as_text(values)} holds a number that is not finite, or too large; "
            f"correct it."
        )
    if min(values[2:4]) < 1 / FARTHEST:
        raise ConfigError(f"The region {as_text(values)} has no area; give it a positive size.")
    return Ellipse.from_box(values) if len(values) == 4 else Ellipse(*values)


def as_region(region: Numbers) -> Box | Ellipse:
    """Return a region as what it was given as, a box or an ellipse; checked as by `as_ellipse`."""
    ellipse = as_ellipse(region)
    return Box(*map(float, region)) if len(region) == 4 else ellipse


def check_angle(theta: float) -> None:
    """Raise a ConfigError if an angle with which an object begins is beyond a turn.

    Later angles may be, as of an object that goes on turning.
    """
    if abs(theta) > 2 * math.pi:
        raise ConfigError(
            f"theta begins with {theta:g}; it is in radians, and a turn is {2 * math.pi:.2f}; a "
            f"box has four numbers"
        )


def as_ellipses(ellipses: ArrayLike) -> Floats:
    """Return ellipses as rows x, y, a, b, theta, (N, 5), whatever their numbers are.

    Raises a ConfigError if it is no such array.
    """
    try:
        given = np.asarray(ellipses)
        rows = given.astype(np.float64, order="C") if given.dtype.kind in "biufO" else np.empty(0)
    except (TypeError, ValueError):
        rows = np.empty(0)
    if rows.ndim != 2 or rows.shape[1] != 5:
        raise ConfigError(
            f"Ellipses are an array (N, 5), rows of x, y, a, b, theta; got "
            f"{' '.join(repr(ellipses).split())[:80]}."
        )
    return rows


def as_samples(ellipses: ArrayLike) -> Floats:
    """Return ellipses (N, 5) at which a target may be, each as `as_ellipse` takes it, one at least.

    Raises a ConfigError if it is no such array, or one is no region.
    """
    rows = as_ellipses(ellipses)
    if not len(rows):
        raise ConfigError("There are no ellipses to look at; give at least one.")
    for row in rows.tolist():
        as_ellipse(row)
    return rows


def region_within(region: Numbers, width: int, height: int) -> Ellipse:
    """Return a region as an ellipse, checked against the size of its frame.

    A region may stick out of the frame, but its center must lie inside, it must not be larger than
    the frame, and it must hold at least two pixels in each direction. Raises a ConfigError if the
    region breaks one of these rules; the message names the rule, and the box that is perhaps
    meant.
    """
    ellipse = as_ellipse(region)
    if not isinstance(region, Ellipse):
        region = tuple(map(float, region))  # as of a line of text that was split
    other = perhaps_meant(region, width, height)
    if not other and len(region) == 4:  # corners in another order; what is refused is no box
        (x1, x2), (y1, y2) = sorted(region[::2]), sorted(region[1::2])
        other = perhaps_meant((x1, y1, x2, y2), width, height)
    other = other and f", or {other}"
    box = ellipse.box
    named = f"The region at x={box.x:g}, y={box.y:g}, {box.width:g}x{box.height:g},"
    frame = f"the frame of {width}x{height}"
    if not (-0.5 <= ellipse.x <= width - 0.5 and -0.5 <= ellipse.y <= height - 0.5):
        raise ConfigError(f"{named} has its center outside {frame}; choose one inside{other}.")
    if box.width > width or box.height > height:
        raise ConfigError(f"{named} is larger than {frame}; choose a smaller one{other}.")
    if min(ellipse.a, ellipse.b) < 1:
        shares = max(region[:4]) <= 1
        what = "give pixels, not shares of the picture" if shares else "choose a larger one"
        raise ConfigError(f"{named} is less than two pixels wide or high; {what}.")
    return ellipse if len(region) == 4 else Angled(*ellipse)


def of_corners(region: Numbers, width: int, height: int) -> Box | None:
    """Return the box whose corners x1, y1, x2, y2 were perhaps given as x, y, width, height.

    That is where the box of these numbers leaves the frame, and that of the corners does not; None
    for all other regions.
    """
    if isinstance(region, Ellipse) and not region.theta:
        region = region.box
    if len(region) != 4:
        return None
    x, y, right, bottom = map(float, region)
    leaves = x + right > width or y + bottom > height
    fits = 0 <= x < right <= width and 0 <= y < bottom <= height
    return Box(x, y, right - x, bottom - y) if leaves and fits else None


def perhaps_meant(region: Numbers, width: int, height: int) -> str:
    """Return the box that a region's numbers perhaps mean, and what they are then; else "".

    They may be corners, or a box and its score, of which the ellipse leaves the frame.
    """
    if (corners := of_corners(region, width, height)) is not None:
        return f"{as_text(corners)} (x,y,width,height) if its numbers are corners x1,y1,x2,y2"
    if len(region) == 5 and 0 < region[4] <= 1:
        box = Box(*region[:4])
        if as_ellipse(region).box.room(width, height) < 0 <= box.room(width, height):
            return f"{as_text(box)} (x,y,width,height) if its fifth number is a score"
    return ""


def as_text(values: Sequence[float]) -> str:
    """Return numbers as users give them."""
    return ",".join(f"{value:g}" for value in values)


def columns(boxes: Floats) -> tuple[Floats, Floats, Floats, Floats]:
    """Return x, y, width and height of boxes (..., 4), each (...)."""
    return boxes[..., 0], boxes[..., 1], boxes[..., 2], boxes[..., 3]


def intersection(first: Floats, second: Floats) -> Floats:
    """Return the areas that boxes (x, y, w, h) share, shapes (..., 4) that broadcast."""
    # Column by column: numpy is slow along an axis as short as that of x and y.
    (x, y, width, height), (left, top, across, down) = columns(first), columns(second)
    wide = np.minimum(x + width, left + across) - np.maximum(x, left)
    high = np.minimum(y + height, top + down) - np.maximum(y, top)
    shared: Floats = np.maximum(wide, 0) * np.maximum(high, 0)
    return shared


def iou(first: ArrayLike, second: ArrayLike) -> Floats:
    """Return the intersection over union of boxes (x, y, w, h), shapes (..., 4) that broadcast.

    A box without area overlaps nothing: 0.
    """
    p, q = np.asarray(first, np.float64), np.asarray(second, np.float64)
    inner = intersection(p, q)
    union = p[..., 2] * p[..., 3] + q[..., 2] * q[..., 3] - inner
    out: Floats = np.divide(inner, union, out=np.zeros_like(np.asarray(inner)), where=union > 0)
    return np.minimum(out, 1.0)  # rounding
