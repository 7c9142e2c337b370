"""Ghosts: detections in places that an object has left after it had become background.

The patch of a real object has edges along its outline. The patch of a ghost has none, but the
learned background has edges there.
"""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
from numpy.typing import NDArray

from motes.core.geometry import Box

Mask = NDArray[np.uint8]
Steps = NDArray[np.int16]


def gradients(pixels: Mask) -> Steps:
    """Return the sum of the gradients in x and y of a picture's green (H, W, 3): (H, W)."""
    green = np.pad(pixels[:, :, 1].astype(np.int16), 1, mode="edge")
    down, across = green[2:, 1:-1] - green[:-2, 1:-1], green[1:-1, 2:] - green[1:-1, :-2]
    total: Steps = np.abs(down) + np.abs(across)
    return total


def without_ghosts(
    boxes: Iterable[Box], mask: Mask, now: Steps, learned: Steps, share: float
) -> list[Box]:
    """Return the boxes that hold an object.

    Parameters
    ----------
    boxes
        The boxes of the mask's patches.
    mask
        (H, W), 1 where the foreground is.
    now, learned
        Gradients of the frame, and of the learned background.
    share
        Along the outline of a ghost, the frame's gradients are on average less than this share of
        the background's.
    """
    outline, kept = _outline(mask), []
    for box in boxes:
        left, top, width, height = map(int, box)
        here = slice(max(top - 1, 0), top + height + 1), slice(max(left - 1, 0), left + width + 1)
        edge = outline[here]
        if now[here][edge].sum() >= share * learned[here][edge].sum():
            kept.append(box)
    return kept


def _outline(mask: Mask) -> NDArray[np.bool_]:
    """Return the pixels on both sides of a mask's border."""
    out = np.zeros(mask.shape, np.bool_)
    down, across = mask[1:] != mask[:-1], mask[:, 1:] != mask[:, :-1]
    out[1:] |= down
    out[:-1] |= down
    out[:, 1:] |= across
    out[:, :-1] |= across
    return out
