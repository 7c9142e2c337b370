"""Boxes as arrays."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from motes.core.geometry import Box
from motes.core.types import Floats

MARGIN = 1.0
"""Pixels that are added to a search area, so that rounding excludes nothing."""


def as_rows(boxes: Iterable[Box]) -> Floats:
    """Return boxes as (n, 4)."""
    return np.array(list(boxes), np.float64).reshape(-1, 4)


def search_areas(centers: Floats, radii: Floats) -> Floats:
    """Return squares (n, 4) that hold circles around centers (n, 2) with radii (n,)."""
    half = radii + MARGIN
    sides = 2 * half[:, None]
    return np.hstack([centers - half[:, None], sides, sides])


def intersection_over_first(first: Floats, second: Floats) -> Floats:
    """Return the share of each first box that the second one covers, shapes (..., 4) broadcast."""
    low = np.maximum(first[..., :2], second[..., :2])
    high = np.minimum(first[..., :2] + first[..., 2:], second[..., :2] + second[..., 2:])
    shares: Floats = np.clip(high - low, 0, None).prod(axis=-1) / first[..., 2:].prod(axis=-1)
    return shares
