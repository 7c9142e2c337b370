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
from motes.core.types import Bytes, Flags, Floats
from motes.mot.detection.morphology import closed, components, opened
from motes.mot.overlaps import CONTAINED, areas, as_rows, covered_pairs
from motes.mot.pairs import Integers

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
SAMPLES = 1000
"""Pixels of a patch, about, that are shared between the objects in it."""
ROUNDS = 4
"""Rounds in which they are shared, each from the centers of the one before."""
NEAR = 2.0
"""Largest distance of a pixel from the center of its object, in half sides of its box."""
REACH = 0.3
"""Largest distance of its center from where it should be, in half sides, too."""
SMALL = 8
"""A patch that is smaller by more than this factor is noise."""
SEEN = 0.25
"""An object is seen in a patch if this share of its box is."""


def blobs(mask: Bytes, least: float, known: Sequence[Box] = ()) -> list[Box]:
    """Return the boxes of the objects in a mask (H, W), 1 where the foreground is, largest first.

    First holes are filled, as through an object's windows one sees the background: a thin roof over
    them is no speck. Then specks are removed, then patches that are near to each other are
    connected, then patches that are too small are left out, and the others divided between the
    objects that are known there, or between their heads. `least` is the smallest area of an object,
    as a share of the mask. The boxes where `known` objects should be also decide whether a division
    is right.
    """
    clean, labels, parts = _patches(mask)
    places, smallest = as_rows(known), round(least * mask.size)
    inside, around, _ = covered_pairs(places, parts[:, :4].astype(float), CONTAINED)
    found: list[tuple[int, Box]] = []
    for number, (x, y, w, h, area) in enumerate(parts.tolist(), start=1):
        if area >= smallest:
            here = slice(y, y + h), slice(x, x + w)
            patch = (labels[here] == number) & clean[here]
            own = inside[around == number - 1]
            objects = _objects(patch, Box(x, y, w, h), area, places, own)
            found += [each for each in objects if each[0] >= smallest]
    return [box for _, box in sorted(found, key=lambda each: -each[0])]


def small_patches(mask: Bytes, least: float) -> int:
    """Return how many patches are too small for objects, by up to a factor of `SMALL`."""
    share = _patches(mask)[2][:, 4] / (least * mask.size)
    return int(np.count_nonzero((share < 1) & (share > 1 / SMALL)))


def _patches(mask: Bytes) -> tuple[Flags, NDArray[np.int32], Integers]:
    """Return a mask without holes and specks, the patches there by number, and their boxes, areas.

    Patches that are near to each other are one.
    """
    sides = zip(GAP, mask.shape, strict=True)
    height, width = (max(1, math.ceil(share * side)) | 1 for share, side in sides)
    solid = mask.copy()
    kernels.components.fill_holes(mask, np.ones_like(mask), solid)
    clean = opened(solid, SPECK)
    return clean.view(np.bool_), *components(closed(clean, (height, width)))


def _objects(
    patch: Flags, whole: Box, area: int, known: Floats, inside: Integers
) -> list[tuple[int, Box]]:
    """Return the areas and boxes of the objects in a patch (h, w) of an area, which `whole` bounds.

    In the place of one known object it is this object. Else it is shared by those that are known
    `inside`, or divided at valleys of its outline. One that holds several known objects is divided
    into as many parts or not at all: else an outline with hollows would tear an object apart while
    another one passes it, and the scene knows better which of them is hidden.
    """
    if np.any(iou(whole, known) > ONE):
        return [(area, whole)]
    if len(inside) > 1:
        boxes, seen = shared(patch, whole, known[inside])
        shown = seen > SEEN * areas(boxes)
        if np.count_nonzero(shown) > 1:
            return [
                (int(own), Box(*box))
                for own, box in zip(seen[shown].tolist(), boxes[shown].tolist(), strict=True)
            ]
    parts = divided(patch.view(np.uint8))
    low, high = whole[:2], (whole.x + whole.width, whole.y + whole.height)
    centers = known[:, :2] + known[:, 2:] / 2
    held = np.count_nonzero(np.all((low < centers) & (centers < high), axis=1))
    if len(parts) > 1 and held in (0, 1, len(parts)):
        pixels = sum(count for *_, count in parts)
        return [
            (area * count // pixels, Box(whole.x + x, whole.y + y, w, h))
            for x, y, w, h, count in parts
        ]
    return [(area, whole)]


def shared(patch: Flags, whole: Box, places: Floats) -> tuple[Floats, Floats]:
    """Return where objects are in a patch that holds them, and the pixels of each: (n, 4), (n,).

    The patch is (h, w), 1 where the foreground is, and `whole` its box; `places` (n, 4) are boxes
    where the objects should be. Each pixel belongs to the object whose center is nearest, in half
    sides of its box, and each center moves to the mean of its pixels (k-means). The sizes stay:
    those in a patch are not seen.
    """
    step = max(1, math.isqrt(np.count_nonzero(patch) // SAMPLES))
    middle = step // 2  # of the squares of which each gives a pixel
    rows, columns = np.nonzero(patch[middle::step, middle::step])
    corner = np.array([whole.x, whole.y]) + middle + 0.5
    pixels = step * np.stack([columns, rows], axis=1) + corner
    half = places[:, 2:] / 2
    centers = predicted = places[:, :2] + half
    for _ in range(ROUNDS):
        far = (((pixels[:, None] - centers) / half) ** 2).sum(axis=2)
        owned = (far.argmin(axis=1)[:, None] == np.arange(len(centers))) & (far < NEAR**2)
        counts = owned.sum(axis=0)
        means = owned.T @ pixels / np.maximum(counts, 1)[:, None]
        means = np.where(counts[:, None] > 0, means, centers)
        centers = np.clip(means, predicted - REACH * half, predicted + REACH * half)
    return np.hstack([centers - half, places[:, 2:]]), counts * float(step**2)


def divided(patch: Bytes) -> list[list[int]]:
    """Return the parts of a patch (h, w) between the valleys of its upper outline, in their order.

    Of each, these are left, top, width and height, and its number of pixels.

    People beside each other have a valley between their heads, and vehicles between their roofs; a
    walker's legs or a vehicle's hood make none. A valley is below the lower one of the peaks beside
    it by `VALLEY`, and the parts on both sides are as wide as `NARROW`.
    """
    height = len(patch)
    spike, least = max(1, round(SPIKE * height)) | 1, max(1, round(NARROW * height))
    parts: list[list[int]] = kernels.outlines.divided(patch, spike, VALLEY, least).tolist()
    return parts
