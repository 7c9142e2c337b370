"""Which foreground is an object's: what was so in the frame before, and what is no ghost.

A gray shirt looks like a shadow of the white wall behind it, and a dark car's side like one of the
road. But light does not turn an object into a shadow. So what has been an object's foreground, and
still differs from the background, stays so; a shadow that lies beside an object has never been.

A ghost is a detection in a place that an object has left after it had become background. The patch
of a real object has edges along its outline. The patch of a ghost has none, but the learned
background has edges there. The edges of the background itself cut thin lines into a patch, as a
table's rim into the person before it: these are no outline.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from motes import kernels
from motes.core.geometry import Box
from motes.core.types import Bytes
from motes.mot.detection.morphology import closed
from motes.mot.overlaps import as_rows, best_partners, overlapping_pairs

SAME = 0.3
"""Least intersection over union of an object's boxes in two frames, as of its detections."""


class ForegroundMemory:
    """The foreground of the frame before, which moves along with the objects that are known."""

    def __init__(self) -> None:
        self._mask: Bytes | None = None
        self._known: Sequence[Box] = ()

    def remember(self, mask: Bytes, known: Sequence[Box]) -> None:
        """Take the foreground (H, W) of a frame, and the objects' boxes in it."""
        self._mask, self._known = mask, known

    def added(self, mask: Bytes, differs: Bytes, known: Sequence[Box]) -> Bytes:
        """Return a mask with what differs where objects had their foreground in the frame before.

        Parameters
        ----------
        mask, differs
            (H, W) of 0 and 1, without and with the pixels that light may explain.
        known
            Boxes of the known objects in this frame.
        """
        if self._mask is None or not known or not self._known:
            return mask
        out = mask.copy()
        rows, last = as_rows(known), as_rows(self._known)
        for i, j in best_partners(*overlapping_pairs(rows, last, SAME)).items():
            dx, dy = (rows[i, :2] - last[j, :2] + (rows[i, 2:] - last[j, 2:]) / 2).round().tolist()
            here, there = _windows(known[i], int(dx), int(dy), mask.shape)
            out[here] |= differs[here] & self._mask[there]
        return out


def _windows(
    box: Box, dx: int, dy: int, shape: tuple[int, ...]
) -> tuple[tuple[slice, slice], tuple[slice, slice]]:
    """Return the pixels of a box, and those dx, dy pixels before, as far as both are in a frame."""
    height, width = shape
    top, left = max(round(box.y), 0, dy), max(round(box.x), 0, dx)
    bottom = max(min(round(box.y + box.height), height, height + dy), top)
    right = max(min(round(box.x + box.width), width, width + dx), left)
    here = slice(top, bottom), slice(left, right)
    return here, (slice(top - dy, bottom - dy), slice(left - dx, right - dx))


GHOST = 0.5
"""Along the outline of a ghost, the frame's gradients in x and y are on average less than this
share of the background's."""
CUT = 5
"""A cut in a patch that is narrower, in pixels, is no outline."""


def without_ghosts(boxes: Sequence[Box], mask: Bytes, now: Bytes, learned: Bytes) -> list[Box]:
    """Return the boxes that hold an object.

    Parameters
    ----------
    boxes
        The boxes of the mask's patches, in whole pixels.
    mask
        (H, W), 1 where the foreground is.
    now, learned
        (H, W, 3), the frame; and (H, W), green of the learned background.
    """
    corners, sums = np.array(boxes, np.int64).reshape(-1, 4), np.empty((len(boxes), 2))
    whole = closed(mask, (CUT, CUT))
    kernels.components.fill_holes(whole, np.ones_like(whole), whole)
    kernels.ghosts.outline_gradients(whole, now, learned, corners, sums)
    real = sums[:, 0] >= GHOST * sums[:, 1]
    return [box for box, holds in zip(boxes, real, strict=True) if holds]
