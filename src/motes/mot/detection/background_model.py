"""The background: how it begins, what it is for each pixel, and what it learns from a frame.

A camera at rest usually sees the background: so it begins with the usual colors, without the
objects before it. It is a mixture of Gaussians.

A background that learns everything forgets what stands still, and slow traffic too. One that never
learns the foreground keeps each mistake for good. So a pixel of the foreground is not learned, but
only up to a limit: a long one where an object is that has moved before, a short one elsewhere.
"""

from __future__ import annotations

import math
from collections.abc import Iterable

import numpy as np

from motes import kernels
from motes.core.geometry import Box
from motes.core.types import Bytes
from motes.kernels.structures import HoldLimits, MixtureLearning
from motes.mot.detection.morphology import dilated
from motes.mot.detection.planes import Planes

KEPT = kernels.preview.MOST
"""Largest number of pictures that are kept."""
HALF = (KEPT + 1) // 2
"""And least number, once as many have come."""
DENSEST = 1 / 3
"""Share of the pictures that show the background of a pixel, at least."""


class Preview:
    """Keeps few pictures of a camera, which are spread over all the time."""

    def __init__(self) -> None:
        self._kept = np.empty((KEPT, 0, 0, 3), np.uint8)
        self._count, self._seen, self._step = 0, 0, 1

    @property
    def pictures(self) -> Bytes:
        """The pictures that are kept, (n, H, W, 3), in their order."""
        return self._kept[: self._count]

    def add(self, picture: Bytes) -> bool:
        """Keep the next picture (H, W, 3) if it is its turn, and return whether they tell more.

        So they do when they are as many as can be, and at the beginning when they are half as many.
        """
        turn = self._seen % self._step == 0
        self._seen += 1
        if turn and self._count == KEPT:  # every other one stays
            for k in range(1, HALF):  # one by one, which needs no memory for all of them
                self._kept[k] = self._kept[2 * k]
            self._count, self._step = HALF, 2 * self._step
        elif turn:
            if not self._count:
                self._kept = np.empty((KEPT, *picture.shape), np.uint8)
            self._kept[self._count] = picture
            self._count += 1
            return self._count in (HALF, KEPT)
        return False


def usual_colors(pictures: Bytes) -> Bytes:
    """Return the usual colors of each pixel in up to `KEPT` pictures (n, H, W, 3): (H, W, 3).

    They are the mean over the third of the pictures whose brightness is closest together, and which
    do not lie within half of the time. The objects before a background differ, and pass; it does
    not, and returns. So it is found also where it is seen in fewer than half of the pictures.
    """
    count, height, width, _ = pictures.shape
    out = np.empty((height, 3 * width), np.uint8)
    rows = pictures.reshape(count, height, 3 * width)
    kernels.preview.usual_colors(rows, math.ceil(count * DENSEST), out)
    return out.reshape(height, width, 3)


FIRST = 5
"""A background begins as if its first picture had come this many times."""
SHARE = 0.9
"""Modes of the background are those of most weight that have this share of it together."""
NEAR = 3.0
"""A mode learns the colors up to this many standard deviations from its mean."""
VARIANCE, LEAST, MOST = 15.0, 4.0, 75.0
"""Variance of a new mode, and the least and largest of all, in squared gray levels."""
PRUNE = 0.05
"""A mode stays if its weight is at least this share of the rate: Zivkovic's prior c_T."""


class Mixture:
    """A mixture of Gaussians for each pixel: Zivkovic, ICPR 2004."""

    def __init__(self, deviations: float) -> None:
        self._squared = deviations**2

    def begin(self, planes: Planes) -> None:
        """Start with a picture as background, and forget the frames before."""
        sizes, (_, height, width) = kernels.mixture, planes.shape
        parts = -(-width // sizes.PART)
        shape = sizes.MODES, height * parts, sizes.FIELDS * sizes.PART
        self._model, self._shape = np.zeros(shape, np.float32), planes.shape
        for number in range(1, FIRST + 1):
            self.learn(planes, 1 / (2 * number))

    def foreground(self, planes: Planes) -> Bytes:
        """Return the pixels that no mode of the background is near, (H, W) of 0 and 1."""
        mask = np.empty(planes.shape[1:], np.uint8)
        kernels.mixture.foreground(self._model, planes, SHARE, self._squared, mask)
        return mask

    def learn(self, planes: Planes, rate: float) -> None:
        """Learn from a picture of the background, which has a share of `rate` from then on."""
        how = MixtureLearning(rate, PRUNE, NEAR**2, VARIANCE, LEAST, MOST)
        kernels.mixture.learn(self._model, planes, how)

    def picture(self) -> Planes:
        """Return the mean colors of the background."""
        out = np.empty(self._shape, np.uint8)
        kernels.mixture.means(self._model, SHARE, out)
        return out


MARGIN = 7
"""Width and height of the window around a foreground pixel that is not learned: rims are mixed."""


class SelectiveUpdate:
    """Keeps for each pixel what it showed when it was last background.

    It begins with a picture (3, H, W) and its time. A pixel of the foreground is not learned for
    `trial` seconds, and inside the boxes of known objects for `patience`.
    """

    def __init__(self, planes: Planes, time: float, trial: float, patience: float) -> None:
        self._clean, self._limits = planes.copy(), HoldLimits(trial, patience)
        self._since = np.full(planes.shape[1:], float(time))

    def learned_from(
        self, planes: Planes, foreground: Bytes, time: float, known: Iterable[Box]
    ) -> Planes:
        """Return the picture to learn: the frame, and old pixels where its foreground is.

        The frame is (3, H, W), its foreground (H, W) of 0 and 1, and its time in seconds. `known`
        are the boxes of objects that have moved.
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
