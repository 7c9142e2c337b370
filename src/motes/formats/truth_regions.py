"""Formats of annotated regions: boxes, polygons and masks.

Each region becomes a box and an ellipse in the coordinates of `motes.core.geometry`, except for the
number of the first pixel, which the text does not contain. The corners of a polygon lie on the
outline: a box x, y, width, height has the corners x, y to x + width, y + height. A box therefore
gives the same region written as a box or as a polygon, as in the polygons and boxes that VOT
published for the same frames.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from motes.core.files import lines_of
from motes.core.geometry import Box, Ellipse
from motes.formats.text import any_number, at, fields_of

MAX_FRAME = 10_000_000
"""Largest frame index that is accepted; about four days of video."""


class TruthRegion(NamedTuple):
    """A target in one frame."""

    box: Box
    """The smallest box around it."""
    ellipse: Ellipse
    """For a box, the inscribed ellipse. For a polygon of four corners, the ellipse inscribed in the
    rectangle with the polygon's center, area, orientation and ratio of second moments. For other
    polygons and masks, the ellipse with their center and second moments."""
    is_box: bool = False
    """Whether the annotation is only a box."""

    @classmethod
    def of_pixels(cls, x: NDArray[np.int64], y: NDArray[np.int64]) -> TruthRegion:
        """Return the region of pixels, of their columns and rows (n,)."""
        if not x.size:
            return ABSENT
        low = float(x.min()), float(y.min())
        box = Box(*low, float(x.max()) - low[0] + 1, float(y.max()) - low[1] + 1)
        (xx, xy), (_, yy) = np.cov(x, y, bias=True)
        # Each pixel is a square, which adds its own second moment, 1/12.
        center, moments = (float(x.mean()), float(y.mean())), (xx + 1 / 12, xy, yy + 1 / 12)
        return cls(box, _ellipse_of_moments(center, moments, scale=2))


_NAN = math.nan
ABSENT = TruthRegion(Box(*[_NAN] * 4), Ellipse(*[_NAN] * 5), is_box=True)
"""The frame has no target."""
UNKNOWN = TruthRegion(*ABSENT)
"""It is not told where the target is, as where a tracker began or has lost it."""


def read_regions(text: str, *, strict: bool = False) -> list[TruthRegion]:
    """Return the regions of a text, one for each frame.

    Each row is a frame, in order, with the fields of `fields_of`.
    A row is one of:

    - a box x, y, width, height;
    - a polygon x, y, x, y … of at least four corners;
    - a mask in VOT's form, `m x, y, width, height, runs …`: runs of pixels in the box, row by row,
      alternately outside and inside the target;
    - no target: NaN alone, a box or polygon without width or height, an empty mask, or VOT's code
      0;
    - an unknown place: VOT's codes of results, 1 where the tracker began, 2 where it has failed.

    Empty lines are skipped. Raises a FormatError if a line has another format, with its number. If
    `strict`, a box with a negative side is an error, instead of no target.
    """
    regions = []
    for number, line in enumerate(lines_of(text), 1):
        if line.strip():
            with at(f"line {number}"):
                regions.append(_parse_row(line.strip(), strict))
    return regions


def _parse_row(row: str, strict: bool) -> TruthRegion:
    mask = row.startswith("m")
    values = [any_number(field) for field in fields_of(row.lstrip("m").strip(" \t,;"))]
    if all(math.isnan(value) for value in values):
        return ABSENT
    if not all(math.isfinite(value) for value in values):
        raise ValueError("the numbers must be finite")
    if mask:
        return _region_of_runs(values)
    if len(values) == 4:
        box = Box(*values)
        if strict and min(box.width, box.height) < 0:
            raise ValueError(f"a box of {box.width:g}x{box.height:g} pixels has a negative side")
        present = box.width > 0 and box.height > 0
        return TruthRegion(box, Ellipse.from_box(box), is_box=True) if present else ABSENT
    if len(values) >= 8 and len(values) % 2 == 0:
        return region_of_corners(np.reshape(values, (-1, 2)))
    if len(values) == 1 and values[0] in (0, 1, 2):
        return UNKNOWN if values[0] else ABSENT
    raise ValueError(
        f"a row has 4 numbers (x, y, width, height) or the 8 and more of a polygon, "
        f"not {len(values)}"
    )


def _region_of_runs(values: list[float]) -> TruthRegion:
    if len(values) < 4 or any(value != int(value) for value in values):
        raise ValueError("a mask is x, y, width, height and runs, all whole numbers")
    x, y, width, height, *runs = map(int, values)
    if min(width, height, *runs) < 0 or sum(runs) > width * height:
        raise ValueError(f"the mask's runs do not fit into its {width}x{height} pixels")
    inside = np.flatnonzero(np.repeat(np.arange(len(runs)) % 2, runs))
    if not inside.size:
        return ABSENT
    return TruthRegion.of_pixels(x + inside % width, y + inside // width)


def region_of_corners(corners: NDArray[np.float64]) -> TruthRegion:
    """Return the region of a polygon of corners (n, 2) on its outline, in order.

    Raises a ValueError if it has no area, or crosses itself.
    """
    low, high = corners.min(axis=0), corners.max(axis=0)
    if (low == high).any():
        return ABSENT
    middle = (low + high) / 2  # moments far from the origin would lose digits
    (x, y), (u, v) = (corners - middle).T, (np.roll(corners, -1, axis=0) - middle).T
    # Integrals over the area are sums over the edges (Green), made positive for both directions.
    cross = x * v - u * y
    cross *= np.copysign(1, cross.sum())
    area = cross.sum() / 2
    if area > 0:
        mx, my = (cross * (x + u)).sum() / (6 * area), (cross * (y + v)).sum() / (6 * area)
        xx = (cross * (x * x + x * u + u * u)).sum() / (12 * area) - mx * mx
        yy = (cross * (y * y + y * v + v * v)).sum() / (12 * area) - my * my
        xy = (cross * (x * v + 2 * x * y + 2 * u * v + u * y)).sum() / (24 * area) - mx * my
        determinant = xx * yy - xy * xy
    if area <= 0 or determinant <= 0:
        raise ValueError("the polygon has no area, or crosses itself")
    # The second moments of an ellipse are a²/4, those of a rectangle with half sides a are a²/3.
    # For four corners the scale is sqrt(3) if they are a rectangle; otherwise it keeps the area.
    scale = math.sqrt(area / 4 / math.sqrt(determinant)) if len(corners) == 4 else 2.0
    # Coordinates of the outline are half a pixel larger than those of pixel centers.
    center = float(middle[0] + mx - 0.5), float(middle[1] + my - 0.5)
    box = Box(*low.tolist(), *(high - low).tolist())
    return TruthRegion(box, _ellipse_of_moments(center, (float(xx), float(xy), float(yy)), scale))


def _ellipse_of_moments(
    center: tuple[float, float], moments: tuple[float, float, float], scale: float
) -> Ellipse:
    """Return the ellipse with half-axes of `scale` standard deviations (xx, xy, yy).

    Its `a` is the axis within 45 degrees of x, so upright regions have the angle 0.
    """
    xx, xy, yy = moments
    theta = math.atan2(math.copysign(2, xx - yy) * xy, abs(xx - yy)) / 2
    cos, sin = math.cos(theta), math.sin(theta)
    along = xx * cos * cos + 2 * xy * cos * sin + yy * sin * sin
    across = xx * sin * sin - 2 * xy * cos * sin + yy * cos * cos
    return Ellipse(*center, scale * math.sqrt(along), scale * math.sqrt(across), theta)
