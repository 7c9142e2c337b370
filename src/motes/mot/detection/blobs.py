"""Objects in a mask of the foreground: its connected parts, divided where they hold several.

Zhao and Pei, section 3.1: the places, sizes and number of the objects are those of the blobs.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from motes import kernels
from motes.core.geometry import Box, iou
from motes.core.types import Bytes, Floats
from motes.mot.boxes import as_rows
from motes.mot.detection.morphology import closed, components, opened

ONE = 0.7
"""A patch with a larger intersection over union with a known object is this object."""
SPECK = 3
"""Least width and height of a patch, in pixels; smaller ones are noise."""
GAP = 0.03, 0.002
"""Largest gap between two patches of one object, in y and in x, as shares of the frame's height and
width: a belt divides a person, but people who walk side by side are two."""
VALLEY = 0.1
"""Least depth of a valley at which a patch is divided, as a share of the lower peak's height over
the patch's lowest row: less than half of a head."""
NARROW = 0.1
"""Least width of a part of a patch, as a share of the patch's height: a person's, seen edge on."""
SPIKE = 0.06
"""Parts of an outline that are narrower than this share of the blob's height are no heads."""


def blobs(mask: Bytes, least: float, known: Sequence[Box] = ()) -> list[Box]:
    """Return the boxes of the objects in a mask (H, W) of 0 and 1, the largest first.

    First holes are filled, as through an object's windows one sees the background: a thin roof over
    them is no speck. Then specks are removed, then patches that are near to each other are
    connected, then patches that are too small are left out, and the others divided between their
    heads.

    Parameters
    ----------
    mask
        1 where the foreground is.
    least
        Smallest area of an object, as a share of the mask.
    known
        Boxes of objects that are known, which decide whether a division is right.
    """
    sides = zip(GAP, mask.shape, strict=True)
    height, width = (max(1, math.ceil(share * side)) | 1 for share, side in sides)
    solid = mask.copy()
    kernels.components.fill_holes(mask, np.ones_like(mask), solid)
    clean, smallest = opened(solid, SPECK), round(least * mask.size)
    labels, parts = components(closed(clean, (height, width)))
    places, clean = as_rows(known), clean.view(np.bool_)
    found: list[tuple[int, Box]] = []
    for number, (x, y, w, h, area) in enumerate(parts.tolist(), start=1):
        if area < smallest:
            continue
        here = slice(y, y + h), slice(x, x + w)
        patch = (labels[here] == number) & clean[here]
        whole = Box(x, y, w, h)
        cuts = divided(patch.view(np.uint8))
        if not cuts or (known and not _plausible(len(cuts) + 1, whole, places)):
            found.append((area, whole))
            continue
        for left, right in zip([0, *cuts], [*cuts, w], strict=True):
            part = patch[:, left:right]
            (own,), (columns,) = part.any(axis=1).nonzero(), part.any(axis=0).nonzero()
            box = Box(
                x + left + int(columns[0]), y + int(own[0]), int(columns[-1] - columns[0]) + 1,
                int(own[-1] - own[0]) + 1,
            )  # fmt: skip
            inside = area * np.count_nonzero(part) // max(np.count_nonzero(patch), 1)
            if inside >= smallest:
                found.append((inside, box))
    return [box for _, box in sorted(found, key=lambda each: -each[0])]


def _plausible(parts: int, patch: Box, known: Floats) -> bool:
    """Return whether a patch may be divided, by the objects known in the frame before, (n, 4).

    A patch in the place of one object is that object. One that holds several known ones is divided
    into as many parts or not at all: else an outline with hollows would tear an object apart while
    another one passes it, and the scene knows better which of them is hidden.
    """
    if np.any(iou(patch, known) > ONE):
        return False
    inside = np.count_nonzero(_holds(patch, known))
    return inside in (0, 1, parts)


def _holds(box: Box, others: Floats) -> NDArray[np.bool_]:
    """Return which of other boxes (n, 4) have their centers in a box."""
    low, high = box[:2], (box.x + box.width, box.y + box.height)
    centers = others[:, :2] + others[:, 2:] / 2
    holds: NDArray[np.bool_] = np.all((low < centers) & (centers < high), axis=1)
    return holds


def divided(patch: Bytes) -> list[int]:
    """Return the columns at which a patch (h, w) is divided: the valleys of its upper outline.

    People beside each other have a valley between their heads, and vehicles between their roofs; a
    walker's legs or a vehicle's hood make none. A valley is below the lower one of the peaks beside
    it by `VALLEY`, and the parts on both sides are as wide as `NARROW`.
    """
    height = len(patch)
    spike, least = max(1, round(SPIKE * height)) | 1, max(1, round(NARROW * height))
    return sorted(kernels.outlines.valleys(patch, spike, VALLEY, least).tolist())
