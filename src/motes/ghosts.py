"""What stood still for so long that it became background leaves a ghost where it was.

A thing before the background has edges where its patch ends, and a ghost has none: these are in the
background that was learned with it.
"""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
from numpy.typing import NDArray

from motes.geometry import Box

Mask = NDArray[np.uint8]


def without_ghosts(
    boxes: Iterable[Box], mask: Mask, pixels: Mask, background: Mask, share: float
) -> list[Box]:
    """Return the boxes in which something is.

    Parameters
    ----------
    boxes
        Of patches of the mask.
    mask
        (H, W), 1 where the foreground is.
    pixels, background
        (H, W, 3), the frame, and what is learned of the background.
    share
        In a ghost, the frame's gradients along the outline of the mask are, on average, less than
        this share of the background's.
    """
    y, x = np.nonzero(_outline(mask))
    now, learned = _gradients(pixels, y, x), _gradients(background, y, x)
    kept = []
    for box in boxes:
        left, top, width, height = box
        here = (x >= left - 1) & (x <= left + width) & (y >= top - 1) & (y <= top + height)
        if now[here].sum() >= share * learned[here].sum():
            kept.append(box)
    return kept


def _outline(mask: Mask) -> NDArray[np.bool_]:
    """Return the pixels on either side of where a mask begins and ends."""
    out = np.zeros(mask.shape, np.bool_)
    down, across = mask[1:] != mask[:-1], mask[:, 1:] != mask[:, :-1]
    out[1:] |= down
    out[:-1] |= down
    out[:, 1:] |= across
    out[:, :-1] |= across
    return out


def _gradients(pixels: Mask, y: NDArray[np.intp], x: NDArray[np.intp]) -> NDArray[np.int64]:
    """Return how much the green of a picture changes at some pixels, in y and x together."""
    height, width = pixels.shape[:2]
    green = pixels[:, :, 1]

    def at(y: NDArray[np.intp], x: NDArray[np.intp]) -> NDArray[np.int64]:
        return green[y, x].astype(np.int64)

    down = at(np.minimum(y + 1, height - 1), x) - at(np.maximum(y - 1, 0), x)
    across = at(y, np.minimum(x + 1, width - 1)) - at(y, np.maximum(x - 1, 0))
    total: NDArray[np.int64] = np.abs(down) + np.abs(across)
    return total
