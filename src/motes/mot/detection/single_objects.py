"""Patches of foreground as objects of known size: parts are joined, and crowds are divided."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from motes.core.geometry import Box
from motes.mot.detection.object_size import ABREAST, ObjectSizes

Patch = NDArray[np.bool_]

PART = 0.5
"""A patch with less than this share of an object's pixels is a part of one, or a small one."""
SEEN = 0.6
"""An object that nothing hides shows at least this share of an object's usual pixels."""
HIDDEN = 0.3
"""One that another hides shows at least this share."""
FITS = 0.6
"""Objects explain a patch if their boxes miss at most this share of what one box misses."""
MOST = 8
"""Largest number of objects in a patch."""
CROWD = 100
"""In a frame with more patches none are joined: all pairs would take too long."""


def joined(parts: NDArray[np.int64], least: int, sizes: ObjectSizes) -> list[list[int]]:
    """Return the numbers of the patches, from 1, that are one object together.

    Parameters
    ----------
    parts
        (n, 5), left, top, width, height and area of each patch.
    least
        Patches with fewer pixels are left out.
    sizes
        How large objects are. Parts are joined if one of them is too small for an object, and both
        together are no larger than objects usually are.
    """
    chosen = np.flatnonzero(parts[:, 4] >= least)
    groups = [[int(n) + 1] for n in chosen]
    if len(groups) > CROWD:
        return groups
    low, high = parts[chosen, :2], parts[chosen, :2] + parts[chosen, 2:4]
    areas = parts[chosen, 4].astype(float)
    while len(groups) > 1:
        i, j = np.triu_indices(len(groups), 1)
        top, bottom = np.minimum(low[i], low[j]), np.maximum(high[i], high[j])
        feet = np.column_stack([(top[:, 0] + bottom[:, 0]) / 2, bottom[:, 1]])
        usual, spreads = sizes.at(feet)
        sure = np.isfinite(spreads)
        room = np.where(sure, usual * np.exp(np.where(sure, spreads, 0)), 0)
        small = np.minimum(areas[i], areas[j]) < PART * sizes.fill * usual.prod(axis=1)
        fits = small & (bottom - top <= room).all(axis=1)
        if not fits.any():
            break
        filled = (areas[i] + areas[j]) / (bottom - top).prod(axis=1)
        best = int(np.where(fits, filled, -1).argmax())
        a, b = int(i[best]), int(j[best])
        low[a], high[a], areas[a] = top[best], bottom[best], areas[a] + areas[b]
        groups[a] += groups.pop(b)
        low, high, areas = (np.delete(each, b, axis=0) for each in (low, high, areas))
    return groups


def explained(
    patch: Patch, corner: tuple[int, int], sizes: ObjectSizes, known: Sequence[Box]
) -> list[tuple[Box, int]]:
    """Return the objects in a patch that is larger than one, each with its pixels; or none.

    The nearest one, whose foot is lowest, is found first. What it covers is taken away, and the
    next one is looked for. One whose foot is hidden by those before it must be known: else a truck
    would be two cars. It stands as far below its upper edge as it is high. A patch that such boxes
    explain no better than one box is one large object.

    Parameters
    ----------
    patch
        (h, w).
    corner
        The left and upper edges of the patch in the picture.
    sizes
        How large objects are.
    known
        Boxes where objects should be.
    """
    left, taken = patch.copy(), np.zeros_like(patch)
    found: list[tuple[Box, int]] = []
    row = len(patch)
    while row > 0 and len(found) < MOST:
        rows = np.flatnonzero(left[:row].any(axis=1))
        if not rows.size:
            break
        row = int(rows[-1]) + 1
        columns = np.flatnonzero(left[row - 1])
        middle = float(columns.mean())
        hidden = row < len(patch) and taken[row : row + 2, columns].mean() > 0.5
        foot = _foot_below(left, middle, row, corner, sizes) if hidden else float(row)
        width, height = _size(middle, foot, corner, sizes)
        if not width:
            return []
        window, pixels = _best_window(left, middle, foot, width, height)
        if pixels >= (HIDDEN if hidden else SEEN) * sizes.fill * width * height:
            own = np.zeros_like(left)
            own[window] = left[window]
            tight = around(own, corner)
            if hidden:
                tight = Box(corner[0] + window[1].start, corner[1] + foot - height, width, height)
            if tight is not None and (not hidden or any(holds(tight, each) for each in known)):
                found.append((tight, pixels))
            left[window], taken[window] = False, True
        else:
            row -= max(1, round(0.1 * height))
    return found if _better(patch, corner, [box for box, _ in found], sizes) else []


def around(patch: Patch, corner: tuple[int, int]) -> Box | None:
    """Return the box around the pixels of a patch in the picture; None if there are none."""
    rows, columns = np.flatnonzero(patch.any(axis=1)), np.flatnonzero(patch.any(axis=0))
    if not rows.size:
        return None
    x, y = int(columns[0]), int(rows[0])
    return Box(corner[0] + x, corner[1] + y, int(columns[-1]) - x + 1, int(rows[-1]) - y + 1)


def holds(box: Box, other: Box) -> bool:
    """Return whether the center of another box lies in a box."""
    x, y = other.x + other.width / 2, other.y + other.height / 2
    return box.x < x < box.x + box.width and box.y < y < box.y + box.height


def _size(
    middle: float, foot: float, corner: tuple[int, int], sizes: ObjectSizes
) -> tuple[int, int]:
    """Return the usual width and height of an object at a foot in a patch, 0 if not known."""
    usual, spreads = sizes.at(np.array([[corner[0] + middle, corner[1] + foot]]))
    if not np.isfinite(spreads).all():
        return 0, 0
    width, height = np.maximum(np.rint(usual[0]), 2).astype(int).tolist()
    return width, height


def _foot_below(
    left: Patch, middle: float, row: int, corner: tuple[int, int], sizes: ObjectSizes
) -> float:
    """Return where the foot of an object is of which the upper part is seen, down to a row."""
    reach = _size(middle, row, corner, sizes)[0] // 2
    beside = left[:row, max(int(middle) - reach, 0) : int(middle) + reach + 1]
    seen = np.flatnonzero(beside.any(axis=1))
    breaks = np.flatnonzero(np.diff(seen) > 1)
    top = float(seen[breaks[-1] + 1] if breaks.size else seen[0]) if seen.size else float(row)
    foot = sizes.foot_below(corner[0] + middle, corner[1] + top) - corner[1]
    return max(foot, float(row))


def _best_window(
    left: Patch, middle: float, foot: float, width: int, height: int
) -> tuple[tuple[slice, slice], int]:
    """Return where beside its foot an object covers most pixels, and how many.

    Of places that are about as good, the one whose side is nearest to the patch's is taken.
    """
    low = max(round(foot) - height, 0)
    sums = np.concatenate([[0], np.cumsum(left[low : round(foot)].sum(axis=0))])
    size = left.shape[1]
    starts = np.arange(max(round(middle) - width, 0), max(min(round(middle), size - width), 0) + 1)
    if not starts.size:
        starts = np.array([max(min(round(middle) - width // 2, size - width), 0)])
    counts = sums[np.minimum(starts + width, size)] - sums[starts]
    own = np.flatnonzero(left[low : round(foot)].any(axis=0))
    ends = (own[0], own[-1]) if own.size else (0, size)
    edge = np.minimum(np.abs(starts - ends[0]), np.abs(starts + width - 1 - ends[1]))
    near = counts >= 0.95 * counts.max()
    start = int(starts[np.where(near, edge, size).argmin()])
    window = slice(low, max(round(foot), low + 1)), slice(start, start + width)
    return window, int(left[window].sum())


def _better(patch: Patch, corner: tuple[int, int], boxes: list[Box], sizes: ObjectSizes) -> bool:
    """Return whether boxes explain a patch better than one large object does."""
    if len(boxes) < 2:
        return False
    covered = np.zeros_like(patch)
    for x, y, width, height in boxes:
        top, begin = max(round(y) - corner[1], 0), max(round(x) - corner[0], 0)
        covered[top : round(y + height) - corner[1], begin : round(x + width) - corner[0]] = True
    high, wide = patch.shape
    usual = np.array(_size(wide / 2, high, corner, sizes), float)
    if not usual.all():
        return False
    abreast = (
        wide >= ABREAST * usual[0]
        and high <= sizes.largest(np.array([[corner[0] + wide / 2, corner[1] + high]]))[0, 1]
    )
    missed = np.count_nonzero(covered != patch)
    return bool(abreast or missed <= FITS * np.count_nonzero(~patch))
