"""Objects in a mask of the foreground: its connected parts, divided where they hold several.

Zhao and Pei, section 3.1: the places, sizes and number of the objects are those of the blobs.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from motes import kernels
from motes.core.geometry import Box, iou
from motes.mot.detection.morphology import Mask, closed, components, opened
from motes.mot.detection.object_size import ObjectSizes
from motes.mot.detection.single_objects import Patch, around, explained, holds, joined

ONE = 0.7
"""A patch with a larger intersection over union with a known object is this object."""
SPIKE = 0.06
"""Parts of an outline that are narrower than this share of the blob's height are no heads."""


class Blob(NamedTuple):
    """An object in a mask: its box, its pixels, and the box and the pixels of its patch."""

    box: Box
    area: int
    patch: Box
    pixels: int


def blobs(
    mask: Mask,
    *,
    speck: int,
    gap: tuple[float, float],
    least: float,
    valley: float,
    narrow: float,
    known: Sequence[Box] = (),
    sizes: ObjectSizes | None = None,
) -> list[Blob]:
    """Return the objects in a mask (H, W) of 0 and 1, the largest first.

    First specks are removed, then patches that are near to each other are connected. Where it is
    known how large objects are, parts that fit into one are joined, and larger patches are divided
    into such objects. Elsewhere patches are divided between their heads. Then objects that are too
    small are left out.

    Parameters
    ----------
    speck, gap, least, valley, narrow
        As in `BackgroundConfig`.
    known
        Boxes of objects that are known, which decide whether a division between heads is right.
    sizes
        How large objects are.
    """
    sides = zip(gap, mask.shape, strict=True)
    height, width = (max(1, math.ceil(share * side)) | 1 for share, side in sides)
    clean, smallest = opened(mask, speck), round(least * mask.size)
    labels, parts = components(closed(clean, (height, width)))
    sizes, found = sizes or ObjectSizes(), list[Blob]()
    groups = joined(parts, smallest, sizes)
    wholes = [_around(parts[np.array(numbers) - 1]) for numbers in groups]
    feet = np.array([(box.x + box.width / 2, box.y + box.height) for box in wholes])
    limits = sizes.largest(feet.reshape(-1, 2))
    for numbers, whole, limit in zip(groups, wholes, limits, strict=True):
        area, (x, y, w, h) = int(parts[np.array(numbers) - 1, 4].sum()), map(int, whole)
        here = slice(y, y + h), slice(x, x + w)
        patch = np.any([labels[here] == n for n in numbers], axis=0) & clean[here].astype(bool)
        if not np.isfinite(limit).all():
            found += _between_heads(patch, whole, area, valley, narrow, known)
        elif whole.width <= limit[0] and whole.height <= limit[1]:
            found.append(Blob(whole, area, whole, area))
        else:
            inside = explained(patch, (x, y), sizes) or [(whole, area)]
            found += [Blob(*each, whole, area) for each in inside]
    large = [each for each in found if each.area >= smallest]
    return sorted(large, key=lambda each: -each.area)


def cut(box: Box, shape: tuple[int, ...]) -> bool:
    """Return whether the border of a picture (H, W) may cut what is in a box."""
    right, low = box.x + box.width, box.y + box.height
    return box.x <= 0 or box.y <= 0 or right >= shape[1] or low >= shape[0]


def _around(parts: NDArray[np.int64]) -> Box:
    """Return the box around patches (n, 5)."""
    low, high = parts[:, :2].min(axis=0), (parts[:, :2] + parts[:, 2:4]).max(axis=0)
    return Box(*low.tolist(), *(high - low).tolist())


def _between_heads(
    patch: Patch, whole: Box, area: int, valley: float, narrow: float, known: Sequence[Box]
) -> list[Blob]:
    """Return the objects in a patch that is divided between its heads."""
    cuts = divided(patch.astype(np.uint8), valley, narrow) if valley else []
    if not cuts or not _plausible(len(cuts) + 1, whole, known):
        return [Blob(whole, area, whole, area)]
    found, pixels = list[Blob](), max(int(patch.sum()), 1)
    for left, right in zip([0, *cuts], [*cuts, patch.shape[1]], strict=True):
        own = np.zeros_like(patch)
        own[:, left:right] = patch[:, left:right]
        box = around(own, (int(whole.x), int(whole.y)))
        if box is not None:
            found.append(Blob(box, area * int(own.sum()) // pixels, whole, area))
    return found


def _plausible(parts: int, patch: Box, known: Sequence[Box]) -> bool:
    """Return whether a patch may be divided, by the objects known in the frame before.

    A patch in the place of one object is that object. One that holds several known ones is divided
    into as many parts or not at all: else an outline with hollows would tear an object apart while
    another one passes it, and the scene knows better which of them is hidden.
    """
    if any(iou(patch, each) > ONE for each in known):
        return False
    inside = sum(holds(patch, each) for each in known)
    return inside < 2 or inside == parts


def divided(patch: Mask, valley: float, narrow: float) -> list[int]:
    """Return the columns at which a patch (h, w) is divided: the valleys of its upper outline.

    People beside each other have a valley between their heads, and vehicles between their roofs; a
    walker's legs or a vehicle's hood make none. A valley is below the lower one of the peaks beside
    it by a share of its height (`valley`), and so wide are the parts on both sides at least
    (`narrow`): shares of the lower peak's height over the lowest row, and of the patch's height.
    """
    height = len(patch)
    spike, least = max(1, round(SPIKE * height)) | 1, max(1, round(narrow * height))
    return sorted(kernels.outlines.valleys(patch, spike, valley, least).tolist())
