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
from motes.core.saved_state import NotNegativeSingles
from motes.core.types import Floats, Singles

DARK, BRIGHT = 15, 245
"""Gray levels between which the light of a point is known: the camera cuts off what is beyond."""
LEAST_POINTS = 100
"""With fewer points that both pictures show, the light counts as unchanged."""
LARGEST_CHANGE = math.log(2)
"""Largest change from one frame to the next, as a logarithm: more is a cut to another scene."""
UNNOTICED = 0.03
"""A smaller difference of the light is left: it moves a gray of 128 by half of a color's bin."""


class Light(msgspec.Struct, frozen=True, eq=False):
    """The light after a frame.

    Attributes
    ----------
    picture
        (h, w), the small picture of the frame.
    level
        Logarithm of the light, relative to that in which the models learned.
    """

    picture: NotNegativeSingles
    level: float = 0.0

    def followed(self, picture: Singles, shift: Floats, frame: Frame) -> Light:
        """Return the light of the next frame.

        Parameters
        ----------
        picture
            The small picture of that frame.
        shift
            (2,), by how much the scene has moved since the last frame, in its pixels.
        frame
            That frame.
        """
        rows, columns = picture.shape
        across = round(float(shift[0]) * columns / frame.width)
        down = round(float(shift[1]) * rows / frame.height)
        # A blurred or sudden pan gives a wrong shift now and then, so that at rest, more is alike.
        pairs = [_overlap(self.picture, picture, *moved) for moved in ((across, down), (0, 0))]
        before, now = min(pairs, key=_difference)
        least, most = 3 * DARK, 3 * BRIGHT  # pictures are sums of three colors
        known = (least < now) & (now < most) & (least < before) & (before < most)
        if np.count_nonzero(known) < LEAST_POINTS:
            return Light(picture, self.level)
        change = math.log(float(np.median(now[known] / before[known])))
        change = min(max(change, -LARGEST_CHANGE), LARGEST_CHANGE)
        return Light(picture, self.level + change)

    def taken_off(self, frame: Frame) -> Frame:
        """Return a frame in the light in which the models learned."""
        if abs(self.level) < UNNOTICED:
            return frame
        pixels = np.empty(frame.pixels.shape, np.uint8)
        kernels.planes.relight(frame.pixels, math.exp(-self.level), pixels)
        return Frame(frame.index, frame.time, pixels)

    def learned(self, rate: float) -> Light:
        """Return the light after the models have learned a share `rate` of the frame.

        What the models follow by themselves need not be taken off for ever, and errors of single
        changes do not add up.
        """
        return Light(self.picture, (1 - rate) * self.level)


def _overlap(before: Singles, now: Singles, across: int, down: int) -> tuple[Singles, Singles]:
    """Return what two pictures both show, if the scene has moved by so many columns and rows."""
    rows, columns = now.shape

    def part(picture: Singles, right: int, low: int) -> Singles:
        left, top = max(right, 0), max(low, 0)
        return picture[top : max(rows + min(low, 0), 0), left : max(columns + min(right, 0), 0)]

    return part(before, -across, -down), part(now, across, down)


def _difference(pair: tuple[Singles, Singles]) -> float:
    """Return the mean difference of two pictures; it is infinite if they show nothing."""
    before, now = pair
    return float(np.abs(now - before).mean()) if now.size else math.inf
