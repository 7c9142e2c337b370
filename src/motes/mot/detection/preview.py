"""What a camera at rest usually sees: a background without the objects before it."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from motes import kernels
from motes.core.types import Bytes

MOST = kernels.preview.MOST
"""Largest number of pictures that are kept."""
HALF = (MOST + 1) // 2
"""And least number, once as many have come."""
DENSEST = 1 / 3
"""Share of the pictures that show the background of a pixel, at least."""


class Preview:
    """Keeps few pictures of a camera, which are spread over all the time."""

    def __init__(self) -> None:
        self._kept = np.empty((MOST, 0, 0, 3), np.uint8)
        self._count, self._seen, self._step = 0, 0, 1

    @property
    def pictures(self) -> NDArray[np.uint8]:
        """The pictures that are kept, (n, H, W, 3), in their order."""
        return self._kept[: self._count]

    def add(self, picture: Bytes) -> bool:
        """Keep the next picture (H, W, 3) if it is its turn, and return whether they tell more.

        So they do when they are as many as can be, and at the begin when they are half as many.
        """
        turn = self._seen % self._step == 0
        self._seen += 1
        if turn and self._count == MOST:  # every other one stays
            for k in range(1, HALF):  # one by one, which needs no memory for all of them
                self._kept[k] = self._kept[2 * k]
            self._count, self._step = HALF, 2 * self._step
        elif turn:
            if not self._count:
                self._kept = np.empty((MOST, *picture.shape), np.uint8)
            self._kept[self._count] = picture
            self._count += 1
            return self._count in (HALF, MOST)
        return False


def usual_colors(pictures: Bytes) -> Bytes:
    """Return the usual colors of each pixel in up to `MOST` pictures (n, H, W, 3): (H, W, 3).

    They are the mean over the third of the pictures whose brightness is closest together, and which
    do not lie within half of the time. The objects before a background differ, and pass; it does
    not, and returns. So it is found also where it is seen in fewer than half of the pictures.
    """
    count, height, width, _ = pictures.shape
    out = np.empty((height, 3 * width), np.uint8)
    rows = pictures.reshape(count, height, 3 * width)
    kernels.preview.usual_colors(rows, math.ceil(count * DENSEST), out)
    return out.reshape(height, width, 3)
