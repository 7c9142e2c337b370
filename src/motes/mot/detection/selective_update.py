"""What a background learns from a frame: not the objects before it, for a time.

A background that learns everything forgets what stands still, and slow traffic too. One that never
learns the foreground keeps each mistake for good. So a pixel of the foreground is not learned, but
only up to a limit: a long one where an object is that has moved before, a short one elsewhere.
"""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from motes import kernels
from motes.core.geometry import Box
from motes.core.types import Bytes
from motes.kernels.structures import HoldLimits
from motes.mot.detection.morphology import dilated
from motes.mot.detection.planes import Planes

MARGIN = 7
"""Width and height of the window around a foreground pixel that is not learned: rims are mixed."""


class SelectiveUpdate:
    """Keeps for each pixel what it showed when it was last background.

    Parameters
    ----------
    planes
        (3, H, W), the first picture.
    time
        Its time in seconds.
    trial, patience
        Seconds for which a pixel of the foreground is not learned, outside and inside the boxes of
        known objects.
    """

    def __init__(self, planes: Planes, time: float, trial: float, patience: float) -> None:
        self._clean, self._limits = planes.copy(), HoldLimits(trial, patience)
        self._since = np.full(planes.shape[1:], float(time))

    def learned_from(
        self, planes: Planes, foreground: Bytes, time: float, known: Iterable[Box]
    ) -> Planes:
        """Return the picture to learn: the frame, and old pixels where its foreground is.

        Parameters
        ----------
        planes
            (3, H, W), the frame.
        foreground
            (H, W) of 0 and 1.
        time
            Of the frame, in seconds.
        known
            Boxes of objects that have moved.
        """
        inside = np.zeros_like(foreground)
        for x, y, width, height in known:
            top, left = max(round(y), 0), max(round(x), 0)
            inside[top : max(round(y + height), 0), left : max(round(x + width), 0)] = 1
        held = dilated(foreground, (MARGIN, MARGIN))
        kernels.selective_update.update(
            planes, held, inside, time, self._limits, self._since, self._clean
        )
        return self._clean
