"""The exposure of a camera: what gives a frame its usual brightness and contrast."""

from __future__ import annotations

import numpy as np

from motes.core.types import Floats, Singles
from motes.mot.detection.morphology import Mask

SPARSE = 8
"""The usual colors are learned from every eighth pixel in x and y."""
RECENT = 50
"""Frames over which the usual colors are learned."""
LARGEST_GAIN = 1.5
"""Largest gain, or its inverse, that is a change of exposure; what is more is another light."""
POINTS = 1024
"""Number of pixels that a curve is read off."""
KNOTS = 8
"""Points of a curve: as many groups of like pixels, of which most must be background."""
NOTICED = 2.0
"""Gray levels; where a gain is nearer than this at all knots, there is no curve."""
BETTER = 0.8
"""A curve is used if it leaves less than this share of what a gain leaves."""


class Exposure:
    """Keeps the usual colors of a still camera's pictures.

    A channel's gain is the median over pixels, so that moving objects do not change it. Where gains
    do not explain the picture, but a curve over the gray values of each channel does, the camera
    has changed its contrast or gamma.
    """

    def __init__(self, pixels: Mask) -> None:
        self._usual = _sparse(pixels)

    def curves(self, pixels: Mask) -> Floats | None:
        """Return the usual value of each value of each color, (3, 257), without rounding.

        There are none where a gain is far from 1: the light has changed, not the exposure.
        """
        usual, sparse = self._usual.reshape(-1, 3), _sparse(pixels).reshape(-1, 3)
        gains = np.median(np.ascontiguousarray((usual / sparse).T), axis=1)
        if (np.maximum(gains, 1 / gains) > LARGEST_GAIN).any():
            return None
        straight: Floats = gains[:, None] * np.arange(257)
        step = max(1, len(usual) // POINTS)
        usual, sparse = usual[::step], sparse[::step]
        x, y = _knots(usual, sparse)
        if (np.abs(gains * x - y) < NOTICED).all() or not (np.diff(x, axis=0) > 0).all():
            return straight  # as in most frames; or noise hides the curve: a camera's curve rises
        bent = np.stack([_line(*channel) for channel in zip(x.T, y.T, strict=True)])
        left, less = (
            float(np.median(np.abs(_of(each, sparse) - usual))) for each in (straight, bent)
        )
        return bent if less < BETTER * left else straight

    def learn(self, pixels: Mask, curves: Floats) -> None:
        """Learn from a picture with its usual exposure."""
        self._usual += (_of(curves, _sparse(pixels)) - self._usual) / RECENT


def tables_of(curves: Floats) -> Mask:
    """Return each color's whole value of each value, (3, 256)."""
    return np.rint(curves[:, :256]).clip(0, 255).astype(np.uint8)


def _knots(usual: Singles, sparse: Singles) -> tuple[Singles, Singles]:
    """Return medians of values and of usual values, (KNOTS, 3), of groups of like pixels (n, 3)."""
    count = len(usual) // KNOTS
    order = np.argsort(usual, axis=0)[: KNOTS * count]
    x, y = (
        np.median(np.take_along_axis(values, order, axis=0).reshape(KNOTS, count, 3), axis=1)
        for values in (sparse, usual)
    )
    return x, y


def _line(x: Singles, y: Singles) -> Floats:
    """Return the usual value of each value of a color: a line through knots, and on beyond."""
    first, last = (np.diff(y) / np.diff(x))[[0, -1]]
    ends = y[0] - first * x[0], y[-1] + last * (256 - x[-1])
    line: Floats = np.interp(np.arange(257), [0, *x, 256], [ends[0], *y, ends[1]])
    return line


def _of(curves: Floats, colors: Singles) -> Singles:
    """Return the values of colors (..., 3) on their curves."""
    values = [curve[colors[..., k].astype(int)] for k, curve in enumerate(curves)]
    return np.stack(values, axis=-1).astype(np.float32)


def _sparse(pixels: Mask) -> Singles:
    """Return the colors of some pixels, all above 0."""
    return 1 + pixels[::SPARSE, ::SPARSE].astype(np.float32)
