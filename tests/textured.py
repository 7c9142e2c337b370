"""Textures: a large scene and frames that show parts of it, and blocks of colors."""

from functools import cache

import numpy as np
import scipy
from numpy.typing import NDArray

from motes.core.frame import Frame
from motes.core.types import Bytes

Color = tuple[int, int, int]
HEIGHT, WIDTH = 240, 320


@cache
def textured() -> Bytes:
    """Return a picture, larger than the frames that show parts of it."""
    shape = 3 * HEIGHT, 3 * WIDTH, 3
    noise = np.random.default_rng(5).standard_normal(shape).astype(np.float32)
    smooth: NDArray[np.float32] = sum(
        scipy.ndimage.gaussian_filter(noise, (s, s, 0)) * s for s in (2, 6, 15)
    )
    return np.clip(128 + 110 * smooth, 0, 255).astype(np.uint8)


def seen(scene: Bytes, left: float, top: float, index: int = 0, light: float = 1.0) -> Frame:
    """Return the frame whose corner lies at a place of the scene, in a light."""
    row, column = round(top), round(left)
    part = scene[row : row + HEIGHT, column : column + WIDTH]
    lit = np.clip(np.rint(light * part), 0, 255).astype(np.uint8)
    return Frame(index, index / 25, lit)


def blocks(seed: int, height: int, width: int, side: int, low: Color, high: Color) -> Bytes:
    """Return a texture of blocks of random colors, from `low` to below `high`."""
    rng = np.random.default_rng(seed)
    coarse = rng.integers(low, high, (height // side + 1, width // side + 1, 3), np.uint8)
    return coarse.repeat(side, axis=0).repeat(side, axis=1)[:height, :width]
