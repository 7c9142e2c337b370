"""Which pixels differ from a background by their light alone, or by a tremble of the camera.

A shadow, a reflection or a cloud scales a pixel's colors by about the same factor and leaves the
edges of the background where they were. An object brings edges and colors of its own.
"""

from __future__ import annotations

import numpy as np

from motes import kernels
from motes.core.types import Bytes
from motes.kernels.structures import LightLimits
from motes.mot.detection.morphology import closed, dilated, eroded
from motes.mot.detection.planes import Planes, window_sums

OUTLINE = 5
"""Gaps of an outline are closed up to this width and height."""


class Background:
    """A picture of the background, (3, H, W), with what frames are compared with.

    A pixel with a color between the smallest and the largest of its neighborhood is background,
    with a margin of `noise` gray levels: a camera that trembles moves colors by a pixel.
    """

    def __init__(self, planes: Planes, noise: float) -> None:
        margin, window = np.uint8(min(np.ceil(noise), 255)), (3, 3)
        low = np.stack([eroded(plane, window) for plane in planes])
        high = np.stack([dilated(plane, window) for plane in planes])
        self.planes = planes
        self.low = low - np.minimum(low, margin)
        self.high = high + np.minimum(255 - high, margin)
        self.sums = window_sums(planes)


def without_light(
    mask: Bytes, planes: Planes, background: Background, limits: LightLimits
) -> Bytes:
    """Return a mask without the pixels that differ from the background by their light alone.

    Colors and gradients are means over 3 x 3 pixels, since noise changes single ones, and the
    gradients of green are compared over 5 x 5 pixels of the mask. `limits` are what another light
    may change, see `BackgroundConfig`; if `shadow` is 1, it changes nothing.

    Parameters
    ----------
    mask
        (H, W) of 0 and 1, the pixels that differ from the background.
    planes
        (3, H, W), the frame.
    """
    if limits.shadow == 1:
        return mask
    out = np.empty_like(mask)
    kernels.illumination.without_light(mask, window_sums(planes), background.sums, limits, out)
    return out


def with_enclosed(mask: Bytes, differs: Bytes) -> Bytes:
    """Return a mask with all that differs from the background inside of its outlines.

    A shadow lies beside an object. What looks like one inside of an outline is the object, such as
    a gray shirt before a white wall.

    Parameters
    ----------
    mask, differs
        (H, W) of 0 and 1, without and with the pixels that light may explain.
    """
    out = mask.copy()
    kernels.components.fill_holes(closed(mask, (OUTLINE, OUTLINE)), differs, out)
    return out


def without_tremble(mask: Bytes, planes: Planes, background: Background) -> Bytes:
    """Return a mask without the pixels whose color the background has in their neighborhood."""
    out = np.empty_like(mask)
    kernels.illumination.without_tremble(mask, planes, background.low, background.high, out)
    return out
