"""Morphology of pictures and masks, by OpenCV, or by SciPy where OpenCV is not installed."""

from __future__ import annotations

import importlib
from functools import cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from motes import kernels
from motes.core.callables import BROKEN, explain, is_missing
from motes.core.types import Bytes


def opencv() -> Any:
    """Return OpenCV, or None where it is not installed, or broken."""
    return _opencv()[0]


def opencv_warnings() -> dict[str, str]:
    """Return the warning that OpenCV is broken and not used, if it is so, by its kind."""
    return dict(_opencv()[1])


@cache
def _opencv() -> tuple[Any, dict[str, str]]:
    try:
        return importlib.import_module("cv2"), {}
    except ImportError as error:
        text = f"OpenCV is not used; {BROKEN.format(explain(error))}."
        return None, {} if is_missing(error, "cv2") else {"opencv": text}


def opened(mask: Bytes, size: int) -> Bytes:
    """Return the opening of a mask: without parts narrower or lower than `size` pixels."""
    return dilated(eroded(mask, (size, size)), (size, size))


def closed(mask: Bytes, size: tuple[int, int]) -> Bytes:
    """Return the closing of a mask: with gaps filled up to a size in y and x."""
    return eroded(dilated(mask, size), size)


def eroded(picture: Bytes, size: tuple[int, int]) -> Bytes:
    """Return the minimum around each pixel (H, W) or (H, W, 3), in a window of y and x."""
    cv2 = opencv()
    if cv2 is not None:
        out: Bytes = cv2.erode(picture, np.ones(size, np.uint8))
        return out
    from scipy import ndimage

    around: Bytes = ndimage.minimum_filter(picture, (*size, 1)[: picture.ndim])
    return around


def dilated(picture: Bytes, size: tuple[int, int]) -> Bytes:
    """Return the maximum around each pixel (H, W) or (H, W, 3), in a window of y and x."""
    cv2 = opencv()
    if cv2 is not None:
        out: Bytes = cv2.dilate(picture, np.ones(size, np.uint8))
        return out
    from scipy import ndimage

    around: Bytes = ndimage.maximum_filter(picture, (*size, 1)[: picture.ndim])
    return around


def components(mask: Bytes) -> tuple[NDArray[np.int32], NDArray[np.int64]]:
    """Return the connected parts of a mask; parts that meet at corners are connected too.

    Returns
    -------
    labels
        (H, W), the number of each pixel's part from 1, or 0.
    parts
        (n, 5), left, top, width, height and area of each part.
    """
    labels = np.empty(mask.shape, np.int32)
    parts = kernels.components.label(np.ascontiguousarray(mask), labels)
    return labels, parts
