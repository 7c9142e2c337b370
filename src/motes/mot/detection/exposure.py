"""The exposure of a camera: what gives a frame its usual brightness and contrast."""

from __future__ import annotations

import numpy as np

from motes.core.types import Bytes, Floats, Singles

SPARSE = 8
"""The usual colors are learned from every eighth pixel in x and y."""
RECENT = 50
"""Frames over which the usual colors are learned."""
LARGEST_GAIN = 1.5
"""Largest gain, gamma or contrast, or its inverse, that is a change of exposure; what is more is
another light."""
POINTS = 1024
"""Number of pixels that a curve is read off."""
KNOTS = 8
"""Groups of like pixels that a curve is read off; in most of them most must be background."""
NOTICED = 2.0
"""Gray levels; where a gain leaves less, in the median, there is no curve."""
BETTER = 0.8
"""A curve is used if it leaves less than this share of what a gain leaves."""


class Exposure:
    """Keeps the usual colors of a still camera's pictures.

    A channel's gain is the median over pixels, so that moving objects do not change it. Where gains
    do not explain the picture, but a gamma or a contrast of each channel does, the camera has
    changed it.
    """

    def __init__(self, pixels: Bytes) -> None:
        self._usual = _sparse(pixels)

    def curves(self, pixels: Bytes) -> Floats | None:
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

        def misfit(curves: Floats) -> float:
            return float(np.median(np.abs(_of(curves, sparse) - usual)))

        left = misfit(straight)
        if left < NOTICED or len(usual) < KNOTS:  # as in most frames, or in a tiny one
            return straight
        best = min(_gamma(usual, sparse), _contrast(usual, sparse), key=misfit)
        return best if misfit(best) < BETTER * left else straight

    def learn(self, pixels: Bytes, curves: Floats) -> None:
        """Learn from a picture with its usual exposure."""
        usual = np.maximum(_of(curves, _sparse(pixels)), 1)
        self._usual += (usual - self._usual) / RECENT


def tables_of(curves: Floats) -> Bytes:
    """Return each color's whole value of each value, (3, 256)."""
    return np.rint(curves[:, :256]).clip(0, 255).astype(np.uint8)


def _gamma(usual: Singles, sparse: Singles) -> Floats:
    """Return the curves, (3, 257), of a gain and a gamma: lines between logarithms."""
    offsets, slopes = _line(np.log(sparse), np.log(usual))
    out: Floats = np.exp(offsets)[:, None] * np.arange(257) ** slopes[:, None]
    return out


def _contrast(usual: Singles, sparse: Singles) -> Floats:
    """Return the curves, (3, 257), of a brightness and a contrast: lines between values."""
    offsets, slopes = _line(sparse, usual)
    out: Floats = offsets[:, None] + slopes[:, None] * np.arange(257)
    return out


def _line(x: Singles, y: Singles) -> tuple[Floats, Floats]:
    """Return offset and slope (3,) of the lines from values x (n, 3) to y.

    A slope is the median of those between the medians of groups of like pixels (Theil and Sen), so
    that one or two groups that objects cover do not change it.
    """
    count = len(y) // KNOTS
    order = np.argsort(y, axis=0)[: KNOTS * count]
    u, v = (
        np.median(np.take_along_axis(values, order, axis=0).reshape(KNOTS, count, 3), axis=1)
        for values in (x, y)
    )
    i, j = np.triu_indices(KNOTS, 1)
    runs = u[j] - u[i]
    slopes = np.divide(v[j] - v[i], runs, out=np.ones_like(runs), where=runs > 0)
    slope = np.clip(np.median(slopes, axis=0), 1 / LARGEST_GAIN, LARGEST_GAIN)
    return np.median(y - slope * x, axis=0), slope


def _of(curves: Floats, colors: Singles) -> Singles:
    """Return the values of colors (..., 3) on their curves."""
    values = [curve[colors[..., k].astype(int)] for k, curve in enumerate(curves)]
    return np.stack(values, axis=-1).astype(np.float32)


def _sparse(pixels: Bytes) -> Singles:
    """Return the colors of some pixels, all above 0."""
    return 1 + pixels[::SPARSE, ::SPARSE].astype(np.float32)
