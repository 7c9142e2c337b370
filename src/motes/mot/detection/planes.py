"""Pictures as three planes, one for each color: compiled loops read them fastest."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from motes import kernels
from motes.core.types import Bytes
from motes.kernels.structures import Sums

Planes = NDArray[np.uint8]
"""(3, H, W): red, green and blue."""
UNCHANGED = np.tile(np.arange(256, dtype=np.uint8), (3, 1))


def planes_of(pixels: Bytes, tables: Bytes = UNCHANGED) -> Planes:
    """Return the planes of a picture (H, W, 3), with values looked up in its tables (3, 256)."""
    out = np.empty((3, *pixels.shape[:2]), np.uint8)
    kernels.planes.expose(pixels, tables, out)
    return out


def window_sums(planes: Planes) -> Sums:
    """Return the sums over the 3 x 3 pixels around each, (3, H, W); a picture goes on mirrored."""
    out = np.empty(planes.shape, np.uint16)
    kernels.planes.window_sums(planes, out)
    return out
