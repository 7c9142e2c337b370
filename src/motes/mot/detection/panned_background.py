"""The background of a camera that pans and zooms: a model that moves along with the picture.

Corners that are followed from frame to frame give the camera's motion as a homography, by RANSAC:
most of them lie on the background. The mean and the variance of each pixel are moved by it.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from motes.core.errors import MissingDependencyError
from motes.core.types import Floats
from motes.mot.detection.illumination import Background, without_tremble
from motes.mot.detection.images import Mask, opencv
from motes.mot.detection.planes import planes_of

WIDTH = 640
"""Pictures are reduced to this width at most."""
CORNERS = 400
"""Number of corners that are followed."""
FEWEST = 12
"""Least number of corners that agree; a homography has 8 unknowns, so 4 corners always do."""
OFF = 2.0
"""Largest distance of a corner that agrees, in pixels."""
KNOWN = 5
"""Frames after which the background of a pixel is known."""
HISTORY = 50
"""Frames over which the background is learned."""
SLOWER = 5.0
"""Foreground is learned more slowly by this factor, so that mistakes heal."""


def camera_motion(before: Mask, after: Mask) -> Floats | None:
    """Return the homography (3, 3) from a gray picture to the next; None if it is not clear."""
    cv2 = opencv()
    corners = cv2.goodFeaturesToTrack(before, CORNERS, 0.01, 8)
    if corners is None or len(corners) < FEWEST:
        return None
    moved, found, _ = cv2.calcOpticalFlowPyrLK(before, after, corners, None)
    seen = found.ravel() == 1
    if seen.sum() < FEWEST:
        return None
    matrix, agrees = cv2.findHomography(corners[seen], moved[seen], cv2.RANSAC, OFF)
    if matrix is None or agrees.sum() < FEWEST:
        return None
    out: Floats = matrix
    return out


class PannedBackground:
    """Separates moving objects from a background before a camera that pans and zooms.

    Parameters
    ----------
    deviations, noise
        As in `BackgroundConfig`.

    Attributes
    ----------
    motion
        The homography (3, 3) from the reduced frame before to the latest one, or None.

    Raises
    ------
    MissingDependencyError
        If OpenCV is not installed.
    """

    motion: Floats | None = None

    def __init__(self, deviations: float = 4.0, noise: float = 4.0) -> None:
        self._cv2 = opencv()
        if self._cv2 is None:
            raise MissingDependencyError(
                "The motion of a camera needs OpenCV; install it with: pip install 'motes[opencv]'."
            )
        self._deviations, self._noise = deviations, noise
        self._gray: Mask | None = None

    def foreground(self, pixels: Mask) -> NDArray[np.bool_]:
        """Return the foreground of the next frame, reduced: (h, w).

        In the first frame, and if the camera's motion is not clear, all may be foreground. Where
        the background came into view a few frames ago, nothing is.
        """
        cv2 = self._cv2
        scale = min(1.0, WIDTH / pixels.shape[1])
        height, width = (max(1, round(scale * side)) for side in pixels.shape[:2])
        small: Mask = cv2.resize(pixels, (width, height), interpolation=cv2.INTER_AREA)
        gray: Mask = cv2.cvtColor(small, cv2.COLOR_RGB2GRAY)
        motion = None
        if self._gray is not None and self._gray.shape == gray.shape:
            motion = camera_motion(self._gray, gray)
        self._gray = gray
        self.motion = motion
        if motion is None:
            self._mean = small.astype(np.float32)
            self._variance = np.full((height, width), self._noise**2, np.float32)
            self._age = np.ones((height, width), np.float32)
            return np.ones((height, width), np.bool_)
        size = width, height
        self._mean = cv2.warpPerspective(self._mean, motion, size)
        self._variance = cv2.warpPerspective(self._variance, motion, size)
        self._age = cv2.warpPerspective(self._age, motion, size, flags=cv2.INTER_NEAREST)
        off = small - self._mean
        squared = (off * off).max(axis=2)
        far = squared > self._deviations**2 * np.maximum(self._variance, self._noise**2)
        picture = np.rint(self._mean).clip(0, 255).astype(np.uint8)
        background = Background(planes_of(picture), self._noise)
        apart = without_tremble(far.astype(np.uint8), planes_of(small), background)
        known = self._age >= KNOWN
        moves = apart.astype(np.bool_) & known
        rate = 1 / np.minimum(self._age + 1, HISTORY)
        rate[moves] /= SLOWER
        self._mean += rate[:, :, None] * off
        self._variance += rate * (squared - self._variance)
        self._age += 1
        return moves
