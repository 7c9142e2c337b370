"""The targets of rendered clips: striped beetles, and how they are painted."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from PIL import Image

from motes.core.geometry import Ellipse
from motes.synthetic.scenery import Floats, noise, to_bytes, window

Color = tuple[int, int, int]
Colors = tuple[Color, Color, Color]

REACH = 1.25
"""A texture covers -REACH … REACH half-axes, so that partly covered pixels get colors too."""


@dataclass(frozen=True, eq=False)
class Target:
    """A striped beetle: its ellipse in every frame and its colors."""

    states: NDArray[np.float64]
    """(frames, 5), x, y, a, b, theta; the head points along a."""
    colors: Colors = ((238, 196, 92), (44, 30, 26), (196, 78, 40))
    """RGB of the shell, its stripes and the head."""
    belly: Colors = ((66, 104, 186), (232, 230, 218), (36, 56, 108))
    """The same for the other side, which is visible after the target has rolled over."""
    roll: NDArray[np.float64] | None = None
    """(frames,), angle of rotation about its long axis, in radians; None for no rotation."""
    crosswise: bool = False
    """Whether its skin is rotated by 90 degrees: the same amount of each color, but other edges."""


def paint(
    pixels: NDArray[np.uint8], unhidden: Floats, texture: Image.Image, ellipse: Ellipse
) -> float:
    """Paint a target and its shadow where nothing hides them; return its visible fraction.

    `pixels` and `unhidden` are changed; `unhidden` is 1 where targets further behind are visible.
    """
    small = min(ellipse.a, ellipse.b)
    part, x, y = window(ellipse, 0.6 * small + 1, unhidden.shape)
    if not unhidden[part].size:
        return 0.0
    u, v = ellipse.inner(x, y)
    radius, slope = np.hypot(u, v), np.hypot(u / ellipse.a, v / ellipse.b)
    distance = (radius - 1) * radius / np.maximum(slope, 1e-6)  # to the edge, in pixels
    seen = np.clip(0.5 - distance, 0, 1) * unhidden[part]
    shadow = np.hypot(*ellipse.inner(x - 0.15 * small, y - 0.3 * small))
    light = 1 - 0.5 * unhidden[part] * np.clip((1.25 - shadow) / 0.5, 0, 1)

    whole = np.array([2 * REACH * ellipse.a, 2 * REACH * ellipse.b])
    wide, high = np.rint(texture.size / whole).astype(int).clip(1).tolist()
    texture = texture.reduce((wide, high))  # otherwise the stripes of small targets would shimmer
    # The map from this part of the picture to the texture, in Pillow's coordinates, whose origin is
    # the corner of the first pixel.
    cos, sin = math.cos(ellipse.theta), math.sin(ellipse.theta)
    turn = np.array([[cos, sin], [-sin, cos]])
    linear = turn * (texture.size / whole)[:, None]
    shift = linear @ (float(x[0]) - 0.5, float(y[0, 0]) - 0.5) + np.array(texture.size) / 2
    matrix = np.column_stack([linear, shift]).ravel().tolist()
    size = (x.size, y.size)
    skin = texture.transform(size, Image.Transform.AFFINE, matrix, Image.Resampling.BILINEAR)
    mixed = pixels[part] * ((1 - seen) * light)[:, :, None]
    pixels[part] = to_bytes(mixed + np.asarray(skin) * seen[:, :, None])
    unhidden[part] -= seen
    return min(float(seen.sum(dtype=np.float64)) / ellipse.area, 1.0)


def texture_of(rng: np.random.Generator, target: Target) -> Callable[[int], Image.Image]:
    """Return a function of the frame that gives a beetle's picture, with its head to the right.

    The picture covers -REACH … REACH half-axes.
    """
    side = max(math.ceil(2 * REACH * target.states[:, 2:4].max()), 128)
    u = np.linspace(-REACH, REACH, side, dtype=np.float32)
    v = u[:, None]
    shade = 0.45 + 0.6 * np.sqrt(np.clip(1 - 0.9 * (u * u + v * v), 0, 1))
    shade *= 1 + 0.06 * noise(rng, side, side, side / 12)
    shine = 90 * np.exp(-((u - 0.05) ** 2) / 0.12 - (v + 0.38) ** 2 / 0.015)

    def lit(skin: Floats) -> Image.Image:
        return Image.fromarray(to_bytes(skin * shade[:, :, None] + shine[:, :, None]))

    def skin(colors: Colors) -> Floats:
        sewn = _skin(u, v, colors)
        return sewn.swapaxes(0, 1) if target.crosswise else sewn

    upper, roll = skin(target.colors), target.roll
    if roll is None:
        picture = lit(upper)
        return lambda index: picture
    lower = skin(target.belly)
    around = np.arcsin(np.clip(u, -1, 1))  # angle of each row from the middle of the upper side

    def rolled(index: int) -> Image.Image:
        turned = around + roll[index]
        rows = np.rint((np.sin(turned) / REACH + 1) * (side - 1) / 2).astype(int)
        shows_upper = np.cos(turned)[:, None, None] >= 0
        return lit(np.where(shows_upper, upper[rows], lower[rows]))

    return rolled


def _skin(u: Floats, v: Floats, colors: Colors) -> Floats:
    """Return one side's colors at columns u and rows v, in half-axes, without light."""
    shell, stripe, head = np.array(colors, np.float32)

    def step(value: Floats, width: float) -> Floats:
        smooth: Floats = np.clip(value / width + 0.5, 0, 1)[:, :, None]
        return smooth

    wave = np.cos(16 * v * (1 + 0.12 * u * u) + 0.3 * np.sin(5 * u))
    skin: Floats = shell + (stripe - shell) * step(wave - 0.1, 0.4)
    front = u - 0.42 + 0.25 * v * v
    skin += (stripe - skin) * step(0.06 - np.abs(front), 0.04)
    skin += (head - skin) * step(front, 0.05)
    skin += (stripe - skin) * step(0.13 - np.hypot(u - 0.72, np.abs(v) - 0.3), 0.05)
    return skin
