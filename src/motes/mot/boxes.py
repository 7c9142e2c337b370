"""Boxes as arrays."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from motes.core.geometry import Box
from motes.core.types import Floats

MARGIN = 1.0
"""Pixels that are added to a search area, so that rounding excludes nothing."""

CUT = 2.0
"""Pixels; a box that is nearer to the border may be cut off by it."""


def as_rows(boxes: Iterable[Box]) -> Floats:
    """Return boxes as (n, 4)."""
    return np.array(list(boxes), np.float64).reshape(-1, 4)


def search_areas(centers: Floats, radii: Floats) -> Floats:
    """Return squares (n, 4) that hold circles around centers (n, 2) with radii (n,)."""
    half = radii + MARGIN
    sides = 2 * half[:, None]
    return np.hstack([centers - half[:, None], sides, sides])


def foot_of(box: Box) -> tuple[float, float]:
    """Return the middle of a box's lower edge, where an object stands on the ground."""
    return box.x + (box.width - 1) / 2, box.y + box.height - 1


def room(box: Box, width: int, height: int) -> float:
    """Return the distance of a box from the border of a picture; below 0 if it reaches beyond."""
    right, low = box.x + box.width, box.y + box.height
    return min(box.x, box.y, width - right, height - low)


def is_cut(box: Box, size: tuple[int, int] | None) -> bool:
    """Return whether the edge of a picture, of a width and height, may cut a box."""
    return size is not None and room(box, *size) < CUT


def intersection_over_first(first: Floats, second: Floats) -> Floats:
    """Return the share of each first box that the second one covers, shapes (..., 4) broadcast."""
    low = np.maximum(first[..., :2], second[..., :2])
    high = np.minimum(first[..., :2] + first[..., 2:], second[..., :2] + second[..., 2:])
    shares: Floats = np.clip(high - low, 0, None).prod(axis=-1) / first[..., 2:].prod(axis=-1)
    return shares
