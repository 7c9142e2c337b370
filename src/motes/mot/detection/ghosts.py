"""Ghosts: detections in places that an object has left after it had become background.

The patch of a real object has edges along its outline. The patch of a ghost has none, but the
learned background has edges there. The edges of the background itself cut thin lines into a patch,
as a table's rim into the person before it: these are no outline.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from motes import kernels
from motes.core.geometry import Box
from motes.core.types import Bytes
from motes.mot.detection.morphology import closed

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
