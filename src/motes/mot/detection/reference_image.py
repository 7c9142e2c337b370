"""The picture that a still camera should see. If the camera moved, a shifted one fits better."""

from __future__ import annotations

import numpy as np

from motes import kernels
from motes.core.types import Bytes, Singles

WIDTH = 160
"""Pictures are reduced to about this width before they are compared."""
SHIFTS = (1, 3, 8)
"""Shifts of the reduced picture that are tried in eight directions, in pixels."""
BETTER = 0.7
"""A camera has moved if a shift leaves less than this share of the misfit.

In films of still cameras the best shift left 0.83 of it or more, in rendered pans 0.6 or less.
"""
NOTICED = 2.0
"""Least decrease of the misfit by that shift, in gray levels; noise causes less."""
SPARSE = 3
"""Every third pixel in x and y is compared."""
SHADES = np.linspace(0.05, 0.95, 10)
"""Shares of the pixels below the gray values from which a change of light is read."""
LASTS = 50
"""Frames for which a reference is used. A background can follow a slower motion."""


class ReferenceImage:
    """Keeps the picture that a camera at rest should see.

    The misfit of two pictures is the median of their differences, so that moving objects do not
    make a shift fit better. Nor does a camera's gain or a cloud: before they are compared, the
    picture is given the shades of the reference, which a shift leaves as they are.
    """

    def __init__(self, pixels: Bytes) -> None:
        self._keep(_reduced(pixels))

    def _keep(self, reduced: Singles) -> None:
        self._kept, self._shades, self._age = reduced, _shades(reduced), 0

    def has_moved(self, pixels: Bytes) -> bool:
        """Return whether a picture of the same size is shifted against the reference."""
        reduced, margin = _reduced(pixels), max(SHIFTS)
        picture = _relit(reduced, self._shades)
        self._age += 1
        height, width = picture.shape
        if min(height, width) <= 2 * margin:
            return False
        inner = self._kept[margin : height - margin : SPARSE, margin : width - margin : SPARSE]

        def differences(dy: int, dx: int) -> Singles:
            y, x = margin + dy, margin + dx
            other = picture[y : y + height - 2 * margin, x : x + width - 2 * margin]
            apart: Singles = np.abs(inner - other[::SPARSE, ::SPARSE])
            return apart

        def fits(dy: int, dx: int) -> bool:  # the median is below the limit if most values are
            return 2 * int(np.count_nonzero(differences(dy, dx) < limit)) > inner.size

        sides = [(dy, dx) for dy in (-1, 0, 1) for dx in (-1, 0, 1) if dy or dx]
        stay = float(np.median(differences(0, 0)))
        limit = min(BETTER * stay, stay - NOTICED)
        moved = limit > 0 and any(fits(far * dy, far * dx) for far in SHIFTS for dy, dx in sides)
        if moved or self._age == LASTS:
            self._keep(reduced)
        return moved


def _relit(picture: Singles, shades: Singles) -> Singles:
    """Return a picture with other shades: as many of its pixels below each of these gray values."""
    own = _shades(picture)
    if np.abs(own - shades).max() < 1:
        return picture
    change = np.interp(np.arange(256), own, shades - own).astype(np.float32)
    relit: Singles = picture + change[picture.astype(np.uint8)]
    return relit


def _shades(picture: Singles) -> Singles:
    """Return the gray values below which shares of the pixels lie."""
    ordered = np.sort(picture[::SPARSE, ::SPARSE], axis=None)
    shades: Singles = ordered[np.rint(SHADES * (len(ordered) - 1)).astype(int)]
    return shades


def _reduced(pixels: Bytes) -> Singles:
    """Return the green channel of a picture, averaged over blocks."""
    block = min(max(1, round(pixels.shape[1] / WIDTH)), pixels.shape[0])
    height, width = pixels.shape[0] // block, pixels.shape[1] // block
    out = np.empty((height, width), np.float32)
    kernels.planes.green_means(pixels, block, out)
    return out
