"""Objects that are cut out of real films, with their soft mattes.

The matte is found by GrabCut from the object's box (Rother, Kolmogorov and Blake, GrabCut, SIGGRAPH
2004); this needs OpenCV.
"""

from __future__ import annotations

import math
from collections.abc import Iterable

import numpy as np
import scipy
from numpy.typing import NDArray
from PIL import Image

from motes.core.errors import SourceError
from motes.core.types import Bytes
from motes.video.sources import open_source
from motes_lab.datasets.sot import Sequence
from motes_lab.dials.cutout import Cutout
from motes_lab.dials.scenes import FilmMaterials

SMALLEST = 40.0
"""Square root of a box's area, in pixels, below which an object is too coarse to be cut out."""
LARGEST = 160.0
"""Square root of a box's area, in pixels, above which its picture is made smaller."""
AROUND = 0.5
"""Surroundings that GrabCut sees on each side, in sides of the box."""
SHARES = (0.3, 0.95)
"""Share of its box that an object covers: with less or more, the cut has failed."""
CORE = 0.45
"""Radius of the part around a box's center that is the object's, in half of its sides."""
ITERATIONS = 6
SMALLEST_FRAME = (360, 240)
"""Smaller films are not used as backgrounds, since they would have to be enlarged much."""


def cut_out(films: Iterable[Sequence]) -> FilmMaterials:
    """Return objects and frames of films.

    An object is cut out of the first frame in which it is large enough. Films whose object is never
    large enough, or stands out too little, give only a frame, and films with small frames only an
    object.

    Raises
    ------
    SourceError
        If a film cannot be read, or there are fewer than two objects or three frames.
    """
    objects: dict[str, Cutout] = {}
    frames: dict[str, Bytes] = {}
    for film in films:
        sides = np.sqrt(film.boxes[:, 2] * film.boxes[:, 3])
        large = np.flatnonzero(sides >= SMALLEST)
        index = int(large[0]) if large.size else int(np.nanargmax(sides))
        with open_source(film.source, start=index, end=index + 1) as source:
            pixels = np.array(next(iter(source)).pixels)
        if pixels.shape[1] >= SMALLEST_FRAME[0] and pixels.shape[0] >= SMALLEST_FRAME[1]:
            frames[film.name] = pixels
        if large.size and (found := _cut(pixels, film.boxes[index])) is not None:
            objects[film.name] = found
    if len(objects) < 2 or len(frames) < 3:
        raise SourceError(
            f"{len(objects)} objects can be cut out, and {len(frames)} films are large enough; "
            f"give a dataset with 2 and 3 or more, or none for rendered scenes."
        )
    return FilmMaterials(objects, frames)


def _cut(pixels: Bytes, box: NDArray[np.float64]) -> Cutout | None:
    """Return the object in a box; None if the cut fails."""
    x, y, width, height = box
    side = math.sqrt(width * height)
    left, top = max(math.floor(x - AROUND * side), 0), max(math.floor(y - AROUND * side), 0)
    right, bottom = math.ceil(x + width + AROUND * side), math.ceil(y + height + AROUND * side)
    image = Image.fromarray(np.ascontiguousarray(pixels[top:bottom, left:right]))
    scale = min(LARGEST / side, 1)
    size = round(image.width * scale), round(image.height * scale)
    part = np.asarray(image.resize(size, Image.Resampling.LANCZOS))
    mask = grab_cut(part, (box - (left, top, 0, 0)) * scale)
    mask = scipy.ndimage.binary_opening(scipy.ndimage.binary_closing(mask))
    labels, _ = scipy.ndimage.label(mask)
    if not labels.any():
        return None
    mask = labels == 1 + int(np.argmax(np.bincount(labels.ravel())[1:]))
    if not SHARES[0] <= mask.sum() / (width * height * scale**2) <= SHARES[1]:
        return None
    return _soft(part, mask)


def grab_cut(part: Bytes, box: NDArray[np.float64]) -> NDArray[np.bool_]:
    """Return the mask (H, W) of the object in a box that GrabCut finds.

    What lies outside of the box is not the object; what lies around its center is.
    """
    import cv2  # takes a quarter of a second to import

    x, y, width, height = box
    rows, columns = np.ogrid[: part.shape[0], : part.shape[1]]
    u = (columns - x - (width - 1) / 2) / (width / 2)
    v = (rows - y - (height - 1) / 2) / (height / 2)
    mask = np.where(np.maximum(abs(u), abs(v)) <= 1, cv2.GC_PR_FGD, cv2.GC_BGD).astype(np.uint8)
    mask[np.hypot(u, v) <= CORE] = cv2.GC_FGD
    if not {cv2.GC_BGD, cv2.GC_FGD} <= set(np.unique(mask).tolist()):  # it needs both
        return np.zeros(mask.shape, np.bool_)
    cv2.setRNGSeed(0)
    models = np.zeros((1, 65)), np.zeros((1, 65))
    bgr = np.ascontiguousarray(part[:, :, ::-1])
    cv2.grabCut(bgr, mask, (0, 0, 0, 0), *models, ITERATIONS, cv2.GC_INIT_WITH_MASK)
    found: NDArray[np.bool_] = (mask == cv2.GC_FGD) | (mask == cv2.GC_PR_FGD)
    return found


def _soft(part: Bytes, mask: NDArray[np.bool_]) -> Cutout | None:
    """Return a cutout with a soft border, just inside of a mask's, and its own colors beyond.

    None if the object is too thin.
    """
    core = scipy.ndimage.binary_erosion(mask)
    inner = scipy.ndimage.binary_erosion(core)
    if not inner.any():
        return None
    _, (rows, columns) = scipy.ndimage.distance_transform_edt(~inner, return_indices=True)
    y, x = (np.flatnonzero(core.any(axis=axis)) for axis in (1, 0))
    window = slice(max(y[0] - 3, 0), y[-1] + 4), slice(max(x[0] - 3, 0), x[-1] + 4)
    matte = scipy.ndimage.gaussian_filter(core[window].astype(np.float32), 0.8)
    return Cutout(np.ascontiguousarray(part[rows, columns][window]), matte.clip(0, 1))
