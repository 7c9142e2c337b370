"""Filters of pictures, by OpenCV, or by SciPy where OpenCV is not installed."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

Mask = NDArray[np.uint8]
Singles = NDArray[np.float32]


def opencv() -> Any:
    """Return OpenCV, or None where it is not installed."""
    try:
        import cv2
    except ImportError:
        return None
    return cv2


def opened(mask: Mask, size: int) -> Mask:
    """Return a mask without parts that are narrower or lower than `size` pixels."""
    return largest(smallest(mask, (size, size)), (size, size))


def closed(mask: Mask, size: tuple[int, int]) -> Mask:
    """Return a mask with gaps filled up to a size in y and x."""
    cv2 = opencv()
    if cv2 is not None:
        out: Mask = cv2.morphologyEx(mask, cv2.MORPH_CLOSE, np.ones(size, np.uint8))
        return out
    return smallest(largest(mask, size), size)


def smallest(picture: Mask, size: tuple[int, int]) -> Mask:
    """Return the minimum around each pixel (H, W) or (H, W, 3), in a window of y and x."""
    cv2 = opencv()
    if cv2 is not None:
        out: Mask = cv2.erode(picture, np.ones(size, np.uint8))
        return out
    from scipy import ndimage

    around: Mask = ndimage.minimum_filter(picture, (*size, 1)[: picture.ndim])
    return around


def largest(picture: Mask, size: tuple[int, int]) -> Mask:
    """Return the maximum around each pixel (H, W) or (H, W, 3), in a window of y and x."""
    cv2 = opencv()
    if cv2 is not None:
        out: Mask = cv2.dilate(picture, np.ones(size, np.uint8))
        return out
    from scipy import ndimage

    around: Mask = ndimage.maximum_filter(picture, (*size, 1)[: picture.ndim])
    return around


def mean(picture: Singles, size: int) -> Singles:
    """Return the mean around each pixel (H, W) or (H, W, 3), in a square of `size` pixels."""
    cv2 = opencv()
    if cv2 is not None:
        out: Singles = cv2.blur(picture, (size, size))
        return out
    from scipy import ndimage

    around: Singles = ndimage.uniform_filter(picture, (size, size, 1)[: picture.ndim])
    return around


def components(mask: Mask, *, corners: bool = True) -> tuple[NDArray[np.int32], NDArray[np.int64]]:
    """Return the connected parts of a mask; parts that meet at `corners` are connected too.

    Returns
    -------
    labels
        (H, W), the number of each pixel's part from 1, or 0.
    parts
        (n, 5), left, top, width, height and area of each part.
    """
    cv2 = opencv()
    if cv2 is not None:
        _, labels, parts, _ = cv2.connectedComponentsWithStats(
            mask, connectivity=8 if corners else 4
        )
        return labels, parts[1:].astype(np.int64)  # the first is the background
    from scipy import ndimage

    labels, count = ndimage.label(mask, np.ones((3, 3)) if corners else None)
    areas = np.bincount(labels.ravel(), minlength=count + 1)[1:]
    boxes = [
        (x.start, y.start, x.stop - x.start, y.stop - y.start)
        for y, x in ndimage.find_objects(labels)
    ]
    return labels, np.hstack([np.reshape(boxes, (-1, 4)), areas[:, None]]).astype(np.int64)
