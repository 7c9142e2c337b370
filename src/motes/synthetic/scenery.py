"""The scenery of rendered clips: a garden floor, plant stems and film grain."""

from __future__ import annotations

import math
from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray
from PIL import Image, ImageFilter

from motes.core.errors import ConfigError
from motes.core.frame import WHOLE
from motes.core.geometry import Ellipse

Floats = NDArray[Any]
"""Arrays of float32; NumPy keeps this type in arithmetic with Python numbers."""

GRAIN = 14
"""Largest value of the film grain, of 255; the scene stays this far from black and white."""
SHIFTS = 64
"""The grain is one noise picture, shifted by 0 … 63 pixels in x and in y in each frame."""
LEAVES = np.frombuffer(
    bytes.fromhex("7a5838 9e7a50 60422c 68703a 486232 58763c 3c522e 807a6e c49e46 96502e b6a27a"),
    np.uint8,
).reshape(-1, 3)
"""Colors (RGB) of the leaves, some of them like a beetle's."""


@lru_cache(maxsize=2)  # they take a hundred times as long as a frame, and many clips have the same
def backdrop(
    seed: int, size: tuple[int, int], stems: tuple[tuple[float, float, float], ...]
) -> tuple[NDArray[np.uint8], Floats, NDArray[np.uint8]]:
    """Return the still parts of a clip: the ground with its stems, their cover, and the grain.

    Parameters
    ----------
    seed
        Determines the ground and the grain.
    size
        Width and height in pixels.
    stems
        For each stem: x in the middle row, width, and shift to the right per row.

    Returns
    -------
    ground
        (height, width, 3).
    cover
        (height, width), 1 where a stem hides everything.
    grain
        (height + SHIFTS, width + SHIFTS, 3), to be added in uint8.
    """
    rng, (width, height) = np.random.default_rng((seed, 0)), size
    ground = _ground(rng, width, height)
    cover = np.zeros((height, width), np.float32)
    for stem in stems:
        _add_stem(rng, ground, cover, *stem)
    coarse = 4 * rng.standard_normal((height + SHIFTS, width + SHIFTS, 1), np.float32)
    fine = coarse + 2 * rng.standard_normal((*coarse.shape[:2], 3), np.float32)
    # Negative grain wraps around in uint8, so that adding it subtracts; this is fast.
    grain = np.rint(fine).clip(-GRAIN, GRAIN).astype(np.int8).view(np.uint8)
    return to_bytes(ground), cover, grain


def _ground(rng: np.random.Generator, width: int, height: int) -> Floats:
    """Return the garden floor: soil and moss, leaves on it, light and depth of field."""
    scale = scale_of((width, height))
    soil, moss = np.array([(84, 66, 48), (78, 88, 46)], np.float32)
    blend = np.clip(0.5 + 0.6 * noise(rng, width, height, 160 * scale), 0, 1)[:, :, None]
    ground: Floats = soil + (moss - soil) * blend
    ground *= 1 + 0.28 * noise(rng, width, height, 24 * scale)[:, :, None]
    for _ in range(round(420 * width * height / (640 * 480 * scale**2))):
        _add_leaf(rng, ground, scale)

    x = np.linspace(-1, 1, width, dtype=np.float32)
    y = np.linspace(-1, 1, height, dtype=np.float32)[:, None]
    ground *= (1.02 - 0.16 * x - 0.10 * (x**2 + y**2))[:, :, None]
    ground *= (1 + 0.14 * noise(rng, width, height, 200 * scale))[:, :, None]
    sharp = Image.fromarray(to_bytes(ground))
    depth = np.abs(y + 0.1 * x - 0.15)
    for radius, start in ((2, 0.25), (6, 0.6)):
        blurred = np.asarray(sharp.filter(ImageFilter.GaussianBlur(radius * scale)), np.float32)
        ground += (blurred - ground) * np.clip((depth - start) / 0.3, 0, 1)[:, :, None]
    return ground


def _add_leaf(rng: np.random.Generator, ground: Floats, scale: float) -> None:
    """Add a leaf with its veins and its shadow at a random position on the ground."""
    height, width = ground.shape[:2]
    x, y, a = rng.uniform((0, 0, 10 * scale), (width, height, 52 * scale)).tolist()
    leaf = Ellipse(x, y, a, a * rng.uniform(0.2, 0.5), rng.uniform(0, 2 * math.pi))
    color = LEAVES[rng.integers(len(LEAVES))] * np.float32(rng.uniform(0.7, 1.1))
    around, dx, dy = window(leaf, 8 * scale, ground.shape)
    part = ground[around]

    def inside(shift: float, softness: float) -> tuple[Floats, Floats, Floats]:
        u, v = leaf.inner(dx - shift, dy - 1.5 * shift)
        return u, v, np.clip((1 - u * u - np.abs(v)) * (leaf.b / softness) + 0.5, 0, 1)

    part *= 1 - 0.45 * inside(2.5 * scale, 4 * scale)[2][:, :, None]
    u, v, alpha = inside(0, 1)
    veins = 0.25 * np.exp(-((v / 0.06) ** 2))
    veins += 0.10 * np.sin(16 * (u + 0.7 * np.abs(v))) * np.abs(v)
    shade = 0.92 + 0.22 * v + 0.12 * np.sin(2.5 * u + 1) + veins
    shade += 0.05 * rng.standard_normal(shade.shape, np.float32)
    part += (color * shade[:, :, None] - part) * alpha[:, :, None]


def _add_stem(
    rng: np.random.Generator,
    ground: Floats,
    cover: Floats,
    middle: float,
    thickness: float,
    lean: float,
) -> None:
    """Add a stem and its shadow to the ground, and to `cover` the part that it hides."""
    height, width = cover.shape
    y, x = np.ogrid[:height, :width]
    shift = lean * (y - (height - 1) / 2)
    across = ((x - middle - shift) / math.hypot(1, lean)).astype(np.float32)
    half = thickness / 2
    ground *= 1 - 0.5 * np.clip((1.5 - np.abs(across / half - 0.35)) / 0.8, 0, 1)[:, :, None]
    alpha = np.clip(half + 0.5 - np.abs(across), 0, 1)
    roundness = np.sqrt(np.clip(1 - (across / half) ** 2, 0, 1))
    bark = 1 + 0.13 * noise(rng, width, height, thickness / 8, stretch=8)
    shade = bark * (0.35 + 0.65 * roundness - 0.25 * across / half)
    color = np.array((112, 104, 72), np.float32) * shade[:, :, None]
    ground += (color - ground) * alpha[:, :, None]
    np.maximum(cover, alpha, out=cover)


def noise(
    rng: np.random.Generator, width: int, height: int, cell: float, stretch: float = 1.0
) -> Floats:
    """Return smooth noise around 0, in octaves from `cell` pixels (times `stretch` in y) to 1."""
    total: Floats = np.zeros((height, width), np.float32)
    strength = 1.0
    while cell >= 1:
        grid = math.ceil(height / cell / stretch) + 3, math.ceil(width / cell) + 3
        coarse = Image.fromarray(strength * rng.standard_normal(grid, np.float32))
        total += np.asarray(coarse.resize((width, height), Image.Resampling.BICUBIC))
        cell, strength = cell / 2, strength * 0.62
    return total


def window(
    ellipse: Ellipse, margin: float, shape: tuple[int, ...]
) -> tuple[tuple[slice, slice], Floats, Floats]:
    """Return the part of a picture that contains an ellipse, and its x and y from the center."""
    box, (height, width) = ellipse.box, shape[:2]
    left, top = max(math.floor(box.x - margin), 0), max(math.floor(box.y - margin), 0)
    right = min(math.ceil(box.x + box.width + margin), width)
    bottom = min(math.ceil(box.y + box.height + margin), height)
    x = np.arange(left, right) - ellipse.x
    y = np.arange(top, bottom)[:, None] - ellipse.y
    part = slice(top, max(bottom, 0)), slice(left, max(right, 0))
    return part, x.astype(np.float32), y.astype(np.float32)


def to_bytes(image: Floats) -> NDArray[np.uint8]:
    """Return values of 0 to 255 as uint8, with a margin for the grain."""
    rounded = np.rint(image)
    return rounded.clip(GRAIN, 255 - GRAIN, out=rounded).astype(np.uint8)


def scale_of(size: tuple[int, int]) -> float:
    """Return how many times larger than 640x480 a frame is, in its relatively smaller direction."""
    if not (hasattr(size, "__len__") and all(isinstance(each, WHOLE) for each in size)):
        raise ConfigError(f"A size is (width, height), two numbers of pixels; got {size!r}.")
    return min(size[0] / 640, size[1] / 480)
