"""The pixels of a tracked target: a mask from the posterior of its colors, inside its ellipse.

p(target | color, place) by Bayes' rule, from histograms of the colors inside the ellipse and around
it, which follow the target as those of Staple do (Bertinetto et al., CVPR 2016, section 3.4). The
prior is one half on the ellipse's border, and grows towards its center.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from motes.core.geometry import Ellipse
from motes.core.types import Bytes, Flags, Floats
from motes.cues.color import SURROUNDINGS

LEVELS = 16
"""Levels of each color: each bin of a target of a thousand pixels has some."""
LEARNING_RATE = 0.04
"""Share of a frame in the histograms, as in `cues.color`."""
REACH = float(np.sqrt(2))
"""A mask ends at this multiple of the half-axes: the ellipse around the ellipse's own rectangle."""
SOFTNESS = 0.15
"""Width of the border on which the prior falls, in half-axes: half the strips of Staple's border.

The boxes around masks of four sequences have an IoU of 0.74 with the truth where it is 0.3, 0.77
where it is 0.15, and 0.76 where it is 0.1.
"""
SMOOTHING = 0.02
"""Standard deviation of the blur of the posterior, relative to the mean side of the target."""


class Colors(NamedTuple):
    """Shares of the colors inside a target and around it, (4096,) each."""

    inside: Floats
    outside: Floats


class Window(NamedTuple):
    """The part of a picture around a target."""

    rows: slice
    columns: slice
    """Where it is in the picture."""
    bins: NDArray[np.intp]
    """(H, W), the bin of each pixel's color."""
    radius: Floats
    """(H, W), the distance of each pixel from the center: 1 on the ellipse."""


def window_of(pixels: Bytes, ellipse: Ellipse) -> Window | None:
    """Return the window of an ellipse in a picture (H, W, 3); None if they do not meet."""
    reach = SURROUNDINGS * REACH * max(ellipse.a, ellipse.b)
    height, width = pixels.shape[:2]
    top, bottom = (int(np.clip(ellipse.y + side, 0, height)) for side in (-reach, reach + 1))
    left, right = (int(np.clip(ellipse.x + side, 0, width)) for side in (-reach, reach + 1))
    if top >= bottom or left >= right:
        return None
    y, x = np.mgrid[top:bottom, left:right] - np.array([ellipse.y, ellipse.x])[:, None, None]
    part = pixels[top:bottom, left:right].astype(np.intp) * LEVELS // 256
    bins = (part[..., 0] * LEVELS + part[..., 1]) * LEVELS + part[..., 2]
    return Window(slice(top, bottom), slice(left, right), bins, np.hypot(*ellipse.inner(x, y)))


def updated(colors: Colors | None, window: Window) -> Colors:
    """Return the colors moved towards those of a window; those of the window if there are none."""
    parts = window.radius <= 1, (window.radius > 1) & (window.radius <= 2)
    new = [np.bincount(window.bins[part], minlength=LEVELS**3).astype(float) for part in parts]
    shares = [counts / max(counts.sum(), 1.0) for counts in new]
    if colors is None:
        return Colors(*shares)
    moved = (
        (1 - LEARNING_RATE) * old + LEARNING_RATE * share
        for old, share in zip(colors, shares, strict=True)
    )
    return Colors(*moved)


def segmented(colors: Colors, window: Window, side: float) -> Flags:
    """Return the mask (H, W) of a target in a window; `side` is its mean side in pixels."""
    from scipy import ndimage

    prior = 1 / (1 + np.exp((window.radius - 1) / SOFTNESS))
    inside, outside = (each[window.bins] for each in colors)
    joint, other = inside * prior, outside * (1 - prior)
    total = joint + other
    # A color that was never seen is no evidence.
    posterior = np.divide(joint, total, out=prior.copy(), where=total > 0)
    smooth = ndimage.gaussian_filter(posterior, SMOOTHING * side, mode="nearest")
    mask = (smooth > 0.5) & (window.radius <= REACH)
    labels, count = ndimage.label(mask)
    if count > 1:
        mask = labels == 1 + int(np.argmax(np.bincount(labels.ravel())[1:]))
    filled: Flags = ndimage.binary_fill_holes(mask)
    return filled


class Segmenter:
    """Masks of a target, frame by frame; its colors are learned on the way."""

    def __init__(self) -> None:
        self._colors: Colors | None = None

    def update(self, pixels: Bytes, ellipse: Ellipse) -> Flags:
        """Learn the colors of a target, and return its mask (H, W)."""
        mask = np.zeros(pixels.shape[:2], np.bool_)
        window = window_of(pixels, ellipse)
        if window is not None:
            self._colors = updated(self._colors, window)
            mask[window.rows, window.columns] = segmented(self._colors, window, ellipse.side)
        return mask
