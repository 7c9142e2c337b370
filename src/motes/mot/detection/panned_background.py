"""The background of a camera that pans and zooms: a model that moves along with the picture.

The mean and the variance of each pixel are moved by the camera's motion. A broadcaster's writing
stays in the picture, so before this background it moves; `PannedBackground.stays` tells it.
"""

from __future__ import annotations

import numpy as np

from motes.core.geometry import Box
from motes.core.types import Bytes, Flags, Floats
from motes.mot.detection.global_motion import GlobalMotion, Model, reduced, scaled
from motes.mot.detection.illumination import Background, without_tremble
from motes.mot.detection.morphology import opencv
from motes.mot.detection.planes import planes_of

WIDTH = 640
"""Pictures are reduced to this width at most."""
KNOWN = 5
"""Frames after which the background of a pixel is known."""
HISTORY = 50
"""Frames over which the background is learned."""
SLOWER = 5.0
"""Foreground is learned more slowly by this factor, so that mistakes heal."""
LEARNED = 250
"""Frames over which foreground is learned; the camera's motions in these frames are kept."""


class PannedBackground:
    """Separates moving objects from a background before a camera that pans and zooms.

    `deviations` and `noise` are as in `BackgroundConfig`, and so is `trial`; without it, foreground
    is learned slowly. `model` is what a motion of the camera is; see `GlobalMotion`. Raises a
    MissingDependencyError if OpenCV is not installed.
    """

    motion: Floats | None = None
    """The motion (3, 3) from the frame before to the latest one, or None."""

    def __init__(
        self,
        deviations: float = 4.0,
        noise: float = 4.0,
        model: Model = "homography",
        trial: float | None = None,
    ) -> None:
        self._camera = GlobalMotion(model)
        self._deviations, self._noise, self._trial = deviations, noise, trial
        self._carried: Floats | None = np.eye(3)

    def glance(self, pixels: Bytes) -> None:
        """Follow the camera alone, into a frame of which no foreground is asked."""
        self.motion, carried = self._camera.update(pixels), self._carried
        self._carried = None if self.motion is None or carried is None else self.motion @ carried

    def foreground(self, pixels: Bytes, time: float = 0.0) -> Flags:
        """Return the foreground of the next frame, at a time in seconds, reduced: (h, w).

        In the first frame, and if the camera's motion is not clear, all may be foreground. Where
        the background came into view a few frames ago, nothing is.
        """
        cv2 = opencv()
        small, self._scale = reduced(pixels, WIDTH)
        height, width = small.shape[:2]
        self.glance(pixels)
        carried, self._carried = self._carried, np.eye(3)
        if carried is None:
            self._still, self._shown = np.zeros((height, width), np.int32), small.copy()
            self._motions = np.eye(3)[None]
            self._moves = np.ones((height, width), np.bool_)
            self._mean = small.astype(np.float32)
            self._variance = np.full((height, width), self._noise**2, np.float32)
            self._age = np.ones((height, width), np.float32)
            self._clear = np.full((height, width), time, np.float32)
            return self._moves
        motion = scaled(carried, self._scale)
        self._compare(small, motion)
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
        if self._trial is None:
            rate[moves] /= SLOWER
        else:  # the time at which a pixel was background moves along, too
            self._clear = cv2.warpPerspective(self._clear, motion, size, flags=cv2.INTER_NEAREST)
            self._clear[~moves] = time
            rate[moves & (time - self._clear < self._trial)] = 0
        self._mean += rate[:, :, None] * off
        self._variance += rate * (squared - self._variance)
        self._age += 1
        self._moves = moves
        return moves

    def stays(self, box: Box) -> bool:
        """Return whether what moves in a box of the latest frame stays in the picture.

        Most of its edges have been where they are since the ground below was elsewhere, farther
        away than the box is wide or high: it is writing on the film. A camera that follows an
        object holds it less exactly, and limbs move.
        """
        x, y, width, height = (self._scale * value for value in box)
        middle = np.array((x + width / 2, y + height / 2, 1))
        ground = self._motions @ middle
        away = np.abs(ground[:, :2] / ground[:, 2:] - middle[:2]) > (width, height)
        ago = np.flatnonzero(away.any(axis=1)[::-1])
        if not len(ago):
            return False
        rows = slice(max(0, round(y)), max(0, round(y + height)))
        part = rows, slice(max(0, round(x)), max(0, round(x + width)))
        edges = self._moves[part] & self._edges[part]
        return bool(2 * (edges & (self._still[part] >= ago[0])).sum() > edges.sum())

    def _compare(self, small: Bytes, motion: Floats) -> None:
        """Note where edges are, for how many frames they have stayed, and where their ground was.

        An edge is where a pixel would change if the picture moved by one.
        """
        cv2 = opencv()
        self._motions = np.concatenate([motion @ self._motions[-LEARNED:], np.eye(3)[None]])
        limits = (0.0,) * 3, (self._deviations * self._noise,) * 3
        around = cv2.morphologyEx(small, cv2.MORPH_GRADIENT, np.ones((3, 3), np.uint8))
        self._edges = cv2.inRange(around, *limits) == 0
        same = cv2.inRange(cv2.absdiff(small, self._shown), *limits)
        self._still = (self._still + 1) * (self._edges & (same > 0))
        cv2.copyTo(small, cv2.bitwise_not(same), self._shown)
