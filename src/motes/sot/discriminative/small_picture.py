"""A frame as a small gray picture: what shows the motion of the camera, and the light.

A cloud, a lamp or the exposure of the camera scales all colors. Then models of colors do not know
the target any more, and a tracker that is not certain does not learn how it looks now. So the
change of the light is measured over the whole picture, where the target counts little: as the
median ratio of two small pictures, after the shift of the camera. Frames are seen in the light in
which the models learned, and the models learn what they see in that light.
"""

from __future__ import annotations

import math
from functools import cache

import msgspec
import numpy as np

from motes import kernels
from motes.core.frame import Frame
from motes.core.geometry import Ellipse
from motes.core.types import Floats, Singles
from motes.cues.fourier import fast_length
from motes.cues.search_window import cut

COLUMNS = 96
"""Largest number of rows and of columns."""


def small_picture(frame: Frame) -> Singles:
    """Return the sums of red, green and blue at evenly spaced points of a frame, (h, w)."""
    rows, columns = small_size(frame.height, frame.width)
    step = frame.width / columns, frame.height / rows
    center = Ellipse((frame.width - 1) / 2, (frame.height - 1) / 2, 1.0, 1.0)
    out: Singles = cut(frame, center, step, (rows, columns)).sum(axis=0)
    return out


@cache
def small_size(height: int, width: int) -> tuple[int, int]:
    """Return the number of rows and columns of the small picture of a frame.

    Fourier transforms of these sizes are fast.
    """
    shrink = min(1.0, COLUMNS / max(height, width))
    rows, columns = (max(round(side * shrink), 1) for side in (height, width))
    return fast_length(rows), fast_length(columns)


def overlap(before: Singles, now: Singles, shift: Floats, frame: Frame) -> tuple[Singles, Singles]:
    """Return what two small pictures both show, if the scene has moved by a shift.

    Parameters
    ----------
    before, now
        (h, w), the pictures.
    shift
        (2,), x and y in pixels of the frames.
    frame
        One of the frames, which are of one size.
    """
    rows, columns = now.shape
    across = round(float(shift[0]) * columns / frame.width)
    down = round(float(shift[1]) * rows / frame.height)

    def part(picture: Singles, right: int, low: int) -> Singles:
        left, top = max(right, 0), max(low, 0)
        return picture[top : max(rows + min(low, 0), 0), left : max(columns + min(right, 0), 0)]

    return part(before, -across, -down), part(now, across, down)


def difference(pictures: tuple[Singles, Singles]) -> float:
    """Return the mean difference of two pictures; it is infinite if they show nothing."""
    before, now = pictures
    return kernels.planes.mean_difference(now, before) if now.size else math.inf


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
        known, ratio = kernels.planes.median_ratio(now, before, least, most)
        if known < LEAST_POINTS:
            return self
        change = min(max(math.log(ratio), -LARGEST_CHANGE), LARGEST_CHANGE)
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
