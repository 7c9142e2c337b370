"""The model of the background of each pixel: a mixture of Gaussians."""

from __future__ import annotations

import numpy as np

from motes import kernels
from motes.core.types import Bytes
from motes.kernels.structures import MixtureLearning
from motes.mot.detection.planes import Planes

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
    """A mixture of Gaussians for each pixel: Zivkovic, ICPR 2004.

    Parameters
    ----------
    deviations
        As in `BackgroundConfig`.
    """

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
