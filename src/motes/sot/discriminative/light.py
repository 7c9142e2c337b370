"""The light of the scene, taken off each frame before the target is looked at.

A cloud, a lamp or the exposure of the camera scales all colors. Then models of colors do not know
the target any more, and a tracker that is not certain does not learn how it looks now. So the
change of the light is measured over the whole picture, where the target counts little: as the
median ratio of two small pictures, after the shift of the camera. Frames are seen in the light in
which the models learned, and the models learn what they see in that light.
"""

from __future__ import annotations

import math

import msgspec
import numpy as np

from motes import kernels
from motes.core.frame import Frame
from motes.core.median import median
from motes.core.types import Singles

DARK, BRIGHT = 15, 245
"""Gray levels between which the light of a point is known: the camera cuts off what is beyond."""
LEAST_POINTS = 100
"""With fewer points that both pictures show, the light counts as unchanged."""
LARGEST_CHANGE = math.log(2)
"""Largest change from one frame to the next, as a logarithm: more is a cut to another scene."""
LARGEST_LEVEL = math.log(16)
"""No more is taken off: in a sixteenth of the light, a byte has no colors left."""
UNNOTICED = 0.12
"""A smaller difference of the light is left: the models follow it by themselves, and a camera that
moves over a scene seems to change the light by up to 0.07. It moves a gray of 128 by two bins of
colors."""


class Light(msgspec.Struct, frozen=True):
    """The light after a frame."""

    level: float = 0.0
    """Logarithm of the light, relative to that in which the models learned."""

    def followed(self, before: Singles, now: Singles) -> Light:
        """Return the light of the next frame.

        Parameters
        ----------
        before, now
            (h, w), what the small pictures of the last and of the next frame both show
            (`small_picture.overlap`).
        """
        least, most = 3 * DARK, 3 * BRIGHT  # pictures are sums of three colors
        known = (least < now) & (now < most) & (least < before) & (before < most)
        if np.count_nonzero(known) < LEAST_POINTS:
            return self
        change = math.log(median(now[known] / before[known]))
        change = min(max(change, -LARGEST_CHANGE), LARGEST_CHANGE)
        return Light(self.level + change)

    def taken_off(self, frame: Frame) -> Frame:
        """Return a frame in the light in which the models learned."""
        if abs(self.level) < UNNOTICED:
            return frame
        level = min(max(self.level, -LARGEST_LEVEL), LARGEST_LEVEL)
        pixels = np.empty(frame.pixels.shape, np.uint8)
        kernels.planes.relight(frame.pixels, math.exp(-level), pixels)
        return Frame(frame.index, frame.time, pixels)

    def learned(self, rate: float) -> Light:
        """Return the light after the models have learned a share `rate` of the frame.

        What the models follow by themselves need not be taken off for ever, and errors of single
        changes do not add up.
        """
        return Light((1 - rate) * self.level)
