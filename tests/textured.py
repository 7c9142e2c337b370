"""A textured scene, and frames that show parts of it."""

from __future__ import annotations

import numpy as np
import scipy
from numpy.typing import NDArray

from motes.core.frame import Frame

HEIGHT, WIDTH = 240, 320


def textured() -> NDArray[np.uint8]:
    """Return a picture, larger than the frames that show parts of it."""
    noise = np.random.default_rng(5).standard_normal((3 * HEIGHT, 3 * WIDTH, 3))
    smooth: NDArray[np.float64] = sum(
        scipy.ndimage.gaussian_filter(noise, (s, s, 0)) * s for s in (2, 6, 15)
    )
    return np.clip(128 + 110 * smooth, 0, 255).astype(np.uint8)


def seen(
    scene: NDArray[np.uint8], left: float, top: float, index: int = 0, light: float = 1.0
) -> Frame:
    """Return the frame whose corner lies at a place of the scene, in a light."""
    row, column = round(top), round(left)
    part = scene[row : row + HEIGHT, column : column + WIDTH]
    lit = np.clip(np.rint(light * part), 0, 255).astype(np.uint8)
    return Frame(index, index / 25, lit)
