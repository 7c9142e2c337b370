"""What a background learns from a frame: not the objects before it, for a time.

A background that learns everything forgets what stands still, and slow traffic too. One that never
learns the foreground keeps each mistake for good. So a pixel of the foreground is not learned, but
only up to a limit: a long one where an object is that has moved before, a short one elsewhere.
"""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from motes.core.geometry import Box
from motes.mot.detection.images import Mask, largest

MARGIN = 7
"""Width and height of the window around a foreground pixel that is not learned: rims are mixed."""


class SelectiveUpdate:
    """Keeps for each pixel what it showed when it was last background.

    Parameters
    ----------
    pixels
        (H, W, 3), the first picture.
    time
        Its time in seconds.
    trial, patience
        Seconds for which a pixel of the foreground is not learned, outside and inside the boxes of
        known objects.
    """

    def __init__(self, pixels: Mask, time: float, trial: float, patience: float) -> None:
        self._clean, self._trial, self._patience = pixels.copy(), trial, patience
        self._since = np.full(pixels.shape[:2], time)

    def learned_from(
        self, pixels: Mask, foreground: Mask, time: float, known: Iterable[Box]
    ) -> Mask:
        """Return the picture to learn: the frame, and old pixels where its foreground is.

        Parameters
        ----------
        pixels
            (H, W, 3), the frame.
        foreground
            (H, W) of 0 and 1.
        time
            Of the frame, in seconds.
        known
            Boxes of objects that have moved.
        """
        held = largest(foreground, (MARGIN, MARGIN)).astype(np.bool_)
        self._since[~held] = time
        limits = np.full(held.shape, self._trial)
        for x, y, width, height in known:
            top, left = max(round(y), 0), max(round(x), 0)
            limits[top : max(round(y + height), 0), left : max(round(x + width), 0)] = (
                self._patience
            )
        held &= time - self._since < limits
        np.copyto(self._clean, pixels, where=~held[:, :, None])
        return self._clean
