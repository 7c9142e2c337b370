"""Patches of foreground as objects of known size: parts are joined, and crowds are divided."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from motes.core.geometry import Box
from motes.mot.detection.object_size import ABREAST, ObjectSizes

Patch = NDArray[np.bool_]

PART = 0.5
"""A patch with less than this share of an object's pixels is a part of one, or a small one."""
SEEN = 0.6
"""An object that nothing hides shows at least this share of an object's usual pixels."""
FITS = 0.6
"""Objects explain a patch if their boxes miss at most this share of what one box misses."""
MOST = 8
"""Largest number of objects in a patch."""
CROWD = 100
"""In a frame with more patches none are joined: all pairs would take too long."""


def joined(parts: NDArray[np.int64], least: int, sizes: ObjectSizes) -> list[list[int]]:
    """Return the numbers of the patches, from 1, that are one object together.

    Patches (n, 5), with left, top, width, height and area, are joined if one of them is too small
    for an object, and both together are no larger than objects usually are. Those with fewer than
    `least` pixels are left out; if sizes are known, only those with fewer than half of that.
    """
    chosen = np.flatnonzero(parts[:, 4] >= (PART * least if sizes.known else least))
    groups = [[int(n) + 1] for n in chosen]
    if not sizes.known or len(groups) > CROWD:
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


def explained(patch: Patch, corner: tuple[int, int], sizes: ObjectSizes) -> list[tuple[Box, int]]:
    """Return the objects in a patch (h, w) that is larger than one, with their pixels; or none.

    The nearest one, whose foot is lowest, is found first. What it covers is taken away, and the
    next one is looked for. One whose foot is hidden by those before it is not told from the upper
    part of a truck. A patch that such boxes explain no better than one box is one large object.
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
        width, height = _size(middle, row, corner, sizes)
        if not width:
            return []
        window, pixels = _best_window(left, middle, row, width, height)
        if pixels and (hidden or pixels >= SEEN * sizes.fill * width * height):
            own = np.zeros_like(left)
            own[window] = left[window]
            box = around(own, corner)
            if box is not None and not hidden:
                found.append((box, pixels))
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


def _best_window(
    left: Patch, middle: float, row: int, width: int, height: int
) -> tuple[tuple[slice, slice], int]:
    """Return where beside its foot an object covers most pixels, and how many.

    Of places that are about as good, the one whose side is nearest to the patch's is taken.
    """
    rows, size = slice(max(row - height, 0), row), left.shape[1]
    sums = np.concatenate([[0], np.cumsum(left[rows].sum(axis=0))])
    first = max(min(round(middle) - width, size - width), 0)
    starts = np.arange(first, max(min(round(middle), size - width), first) + 1)
    counts = sums[np.minimum(starts + width, size)] - sums[starts]
    begin, end = np.flatnonzero(left[rows].any(axis=0))[[0, -1]]
    edge = np.minimum(np.abs(starts - begin), np.abs(starts + width - 1 - end))
    start = int(starts[np.where(counts >= 0.95 * counts.max(), edge, size).argmin()])
    window = rows, slice(start, start + width)
    return window, int(left[window].sum())


def _better(patch: Patch, corner: tuple[int, int], boxes: list[Box], sizes: ObjectSizes) -> bool:
    """Return whether boxes explain a patch better than one large object does."""
    if len(boxes) < 2:
        return False
    covered = np.zeros_like(patch)
    for x, y, width, height in boxes:
        top, begin = int(y) - corner[1], int(x) - corner[0]
        covered[top : top + int(height), begin : begin + int(width)] = True
    high, wide = patch.shape
    foot = np.array([[corner[0] + wide / 2, corner[1] + high]])
    if wide >= ABREAST * sizes.at(foot)[0][0, 0] and high <= sizes.largest(foot)[0, 1]:
        return True
    return bool(np.count_nonzero(covered != patch) <= FITS * np.count_nonzero(~patch))
