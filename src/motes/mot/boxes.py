"""Boxes as arrays."""

from __future__ import annotations

from collections.abc import Iterable
from itertools import chain

import numpy as np

from motes.core.geometry import Box, intersection
from motes.core.types import Floats

MARGIN = 1.0
"""Pixels that are added to a search area, so that rounding excludes nothing."""


def as_rows(boxes: Iterable[Box]) -> Floats:
    """Return boxes as (n, 4)."""
    return np.fromiter(chain.from_iterable(boxes), np.float64).reshape(-1, 4)


def inscribed(boxes: Floats) -> Floats:
    """Return the upright ellipses in boxes (n, 4), as `Ellipse.from_box` does: (n, 5)."""
    centers = boxes[:, :2] + (boxes[:, 2:] - 1) / 2
    return np.hstack([centers, boxes[:, 2:] / 2, np.zeros((len(boxes), 1))])


def search_areas(centers: Floats, radii: Floats) -> Floats:
    """Return squares (n, 4) that hold circles around centers (n, 2) with radii (n,)."""
    half = radii + MARGIN
    sides = 2 * half[:, None]
    return np.hstack([centers - half[:, None], sides, sides])


def areas(boxes: Floats) -> Floats:
    """Return the areas of boxes, shape (..., 4)."""
    found: Floats = boxes[..., 2] * boxes[..., 3]
    return found


def intersection_over_first(first: Floats, second: Floats) -> Floats:
    """Return the share of each first box that the second one covers, shapes (..., 4) broadcast."""
    return intersection(first, second) / areas(first)
