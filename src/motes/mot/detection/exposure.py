"""The exposure of a camera: what gives a frame its usual brightness and contrast."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from motes import kernels
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
FIRST, SECOND = np.triu_indices(KNOTS, 1)
"""All pairs of them."""
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
        self._usual = self._seen = _sparse(pixels)

    def curves(self, pixels: Bytes) -> Floats | None:
        """Return the usual value of each value of each color, (3, 257), without rounding.

        There are none where a gain is far from 1: the light has changed, not the exposure.
        """
        usual, sparse = self._usual, _sparse(pixels)
        self._seen = sparse
        gains = _medians(usual / sparse)
        if (np.maximum(gains, 1 / gains) > LARGEST_GAIN).any():
            return None
        straight: Floats = gains[:, None] * np.arange(257.0)
        step = max(1, usual.shape[1] // POINTS)
        usual, sparse = usual[:, ::step], sparse[:, ::step]

        def misfit(curves: Floats) -> float:
            return float(_medians(np.abs(_of(curves, sparse) - usual).reshape(1, -1))[0])

        left = misfit(straight)
        if left < NOTICED or usual.shape[1] < KNOTS:  # as in most frames, or in a tiny one
            return straight
        others = _gamma_and_contrast(usual, sparse)
        least, best = min(((misfit(each), each) for each in others), key=lambda pair: pair[0])
        return best if least < BETTER * left else straight

    def learn(self, curves: Floats) -> None:
        """Learn from the last picture, whose curves these are."""
        usual = np.maximum(_of(curves, self._seen), 1)
        self._usual += (usual - self._usual) / RECENT


def tables_of(curves: Floats) -> Bytes:
    """Return each color's whole value of each value, (3, 256)."""
    return np.rint(curves[:, :256]).clip(0, 255).astype(np.uint8)


def _gamma_and_contrast(usual: Singles, sparse: Singles) -> tuple[Floats, Floats]:
    """Return the curves, (3, 257), of a gain and a gamma, and of a brightness and a contrast.

    These are lines between logarithms, and between values. A slope is the median of those between
    the medians of groups of like pixels (Theil and Sen), so that one or two groups that objects
    cover do not change it.
    """
    count = usual.shape[1] // KNOTS
    order = np.argsort(usual, axis=1)[:, : KNOTS * count]
    x, y = (_taken(values, order).reshape(3, KNOTS, count) for values in (sparse, usual))
    middle = (count - 1) // 2, count // 2
    u, v = np.partition(x, middle, axis=2)[:, :, middle], y[:, :, middle]
    offsets, slopes = _line(sparse, usual, u, v)
    contrast: Floats = offsets[:, None] + slopes[:, None] * np.arange(257)
    offsets, slopes = _line(*map(np.log, (sparse, usual, u, v)))
    gamma: Floats = np.exp(offsets)[:, None] * np.arange(257) ** slopes[:, None]
    return gamma, contrast


def _line(x: Singles, y: Singles, u: Singles, v: Singles) -> tuple[Singles, Singles]:
    """Return offset and slope (3,) of the lines from values x (3, n) to y.

    `u` and `v` are the x and y of groups of pixels, (3, KNOTS, 2): both values in the middle.
    """
    across, up = (ends[..., 0] + ends[..., 1] for ends in (u, v))  # twice the medians
    runs = across[:, SECOND] - across[:, FIRST]
    rises = up[:, SECOND] - up[:, FIRST]
    slopes = np.divide(rises, runs, out=np.ones_like(runs), where=runs > 0)
    slope = np.clip(_medians(slopes), 1 / LARGEST_GAIN, LARGEST_GAIN)
    return _medians(y - slope[:, None] * x), slope


def _medians(values: Singles) -> Singles:
    out = np.empty(len(values), np.float32)
    kernels.planes.medians(np.ascontiguousarray(values), out)
    return out


def _of(curves: Floats, colors: Singles) -> Singles:
    """Return the values of colors (3, n) on their curves."""
    return _taken(curves, colors.astype(np.intp)).astype(np.float32)


def _taken(rows: NDArray[Any], places: NDArray[np.intp]) -> NDArray[Any]:
    """Return values of three rows at their places (3, n), faster than take_along_axis."""
    values: NDArray[Any] = rows.take(places + rows.shape[1] * np.arange(3)[:, None])
    return values


def _sparse(pixels: Bytes) -> Singles:
    """Return the colors of some pixels, all above 0: (3, n)."""
    colors = pixels[::SPARSE, ::SPARSE].reshape(-1, 3).T
    return np.add(1, colors, dtype=np.float32, order="C")
