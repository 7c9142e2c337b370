"""Changes of a cutout's appearance: its colors, its texture, and the side that it shows."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike, NDArray
from PIL import Image

from motes.core.types import Bytes, Floats
from motes_lab.dials.cutout import Cutout


def recolored(cutout: Cutout, matrix: ArrayLike, shift: ArrayLike = 0) -> Cutout:
    """Return a cutout whose colors c (3,) have become matrix c + shift."""
    return Cutout(as_bytes(cutout.pixels @ np.asarray(matrix).T + shift), cutout.matte)


def as_bytes(values: NDArray[np.floating]) -> Bytes:
    """Return gray levels as whole numbers from 0 to 255."""
    whole: Bytes = np.rint(values.clip(0, 255)).astype(np.uint8)
    return whole


def hue_rotation(angle: float) -> Floats:
    """Return the matrix that rotates colors about the gray axis (Rodrigues' formula)."""
    cross = np.array([[0, -1, 1], [1, 0, -1], [-1, 1, 0]]) / math.sqrt(3)
    rotation: Floats = np.eye(3) + math.sin(angle) * cross + (1 - math.cos(angle)) * cross @ cross
    return rotation


def color_moments(colors: Bytes) -> tuple[Floats, Floats]:
    """Return the mean and the standard deviation of each channel of colors (..., 3)."""
    flat = colors.reshape(-1, 3)
    return flat.mean(axis=0), flat.std(axis=0)


def matched(cutout: Cutout, colors: Bytes, share: float) -> Cutout:
    """Return a cutout whose colors' moments have gone a share of the way to those of others."""
    mean, deviation = color_moments(cutout.inside)
    other, spread = color_moments(colors)
    gain = 1 + share * (spread / np.maximum(deviation, 1) - 1)
    return recolored(cutout, np.diag(gain), mean + share * (other - mean) - gain * mean)


def flattened(cutout: Cutout, share: float) -> Cutout:
    """Return a cutout that has lost a share of its texture."""
    mean, _ = color_moments(cutout.inside)
    return recolored(cutout, (1 - share) * np.eye(3), share * mean)


def rolled(front: Cutout, back: Cutout, angle: float) -> Cutout:
    """Return how an object looks after it has turned about its upright axis.

    Each of its rows is half of a cylinder's girth; the texture of another object is on the other
    half.
    """
    height, width = front.matte.shape
    other = np.asarray(Image.fromarray(back.pixels).resize((width, height)))
    around = np.concatenate([front.pixels, other], axis=1)
    u = np.linspace(-1, 1, width)
    # The unturned picture is shown as it is: each column has its own place on the girth.
    seen = np.sin(np.arcsin(u) + angle)
    facing = np.cos(np.arcsin(u) + angle) >= 0
    column = np.rint((seen + 1) / 2 * (width - 1)).astype(int)
    return Cutout(around[:, np.where(facing, column, 2 * width - 1 - column)], front.matte)
