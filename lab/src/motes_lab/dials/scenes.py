"""What films with dials are made of: objects and pictures behind them, rendered or from real films.

A scene is drawn by a random generator from a material. `Garden` renders it; `FilmMaterials` cuts
objects out of the first frames of sequences with truth, and puts them into the frames of others.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import NamedTuple, Protocol

import numpy as np
from PIL import Image

from motes.core.types import Bytes, Floats
from motes.synthetic.beetle import REACH, Target, texture_of
from motes.synthetic.scenery import backdrop, noise
from motes_lab.dials.appearance import hue_rotation, recolored
from motes_lab.dials.cutout import Cutout

CUTOUT_SIDE = 128
"""Width and height of the pictures of rendered objects and occluders, in pixels."""


class SceneMaterials(NamedTuple):
    """What a film shows.

    Attributes
    ----------
    background
        (H, W, 3), RGB.
    target, back
        The target, and an object whose texture is its other side.
    occluder
        What may pass in front of it.
    """

    background: Bytes
    target: Cutout
    back: Cutout
    occluder: Cutout


class Material(Protocol):
    """What scenes are made of."""

    def scene(self, rng: np.random.Generator, size: tuple[int, int]) -> SceneMaterials:
        """Return a scene with a background of a width and height."""
        ...


@dataclass(frozen=True)
class Garden:
    """Rendered beetles of any color on a garden floor of any color; it needs no data."""

    def scene(self, rng: np.random.Generator, size: tuple[int, int]) -> SceneMaterials:
        """Return a scene with a background of a width and height."""
        ground, other = (_ground(rng, size) for _ in range(2))
        target, back = (_beetle(rng) for _ in range(2))
        return SceneMaterials(ground, target, back, _occluder(rng, other))


@dataclass(frozen=True)
class FilmMaterials:
    """Objects that were cut out of real films, and frames of films.

    Attributes
    ----------
    objects, frames
        By the name of the film. An object is never put before its own film, where it is to be seen
        once more.
    """

    objects: Mapping[str, Cutout]
    frames: Mapping[str, Bytes]

    def scene(self, rng: np.random.Generator, size: tuple[int, int]) -> SceneMaterials:
        """Return a scene with a background of a width and height."""
        target, back = rng.choice(sorted(self.objects), 2, replace=False).tolist()
        others = sorted(self.frames.keys() - {target})
        behind, front = rng.choice(others, 2, replace=False).tolist()
        background, other = (_fitted(rng, self.frames[name], size) for name in (behind, front))
        return SceneMaterials(
            background, self.objects[target], self.objects[back], _occluder(rng, other)
        )


def _ground(rng: np.random.Generator, size: tuple[int, int]) -> Bytes:
    ground, _, _ = backdrop(rng, size, ())
    return recolored(Cutout(ground, np.ones(ground.shape[:2], np.float32)), *_tint(rng)).pixels


def _tint(rng: np.random.Generator) -> tuple[Floats, Floats]:
    """Return a rotation of colors about the gray axis, and a change of brightness."""
    return hue_rotation(rng.uniform(0, 2 * math.pi)), np.full(3, rng.uniform(-15, 35))


def _beetle(rng: np.random.Generator) -> Cutout:
    """Return a beetle of random colors and proportions, upright or lying."""
    half = CUTOUT_SIDE / 2
    a, b = half, half * rng.uniform(0.55, 0.9)
    picture = texture_of(rng, Target(np.array([[0, 0, half, half, 0.0]])))(0)
    width, height = round(2 * REACH * a), round(2 * REACH * b)
    picture = picture.resize((width, height), Image.Resampling.BICUBIC)
    y, x = np.ogrid[:height, :width]
    u, v = (x + 0.5 - width / 2) / a, (y + 0.5 - height / 2) / b
    matte = np.clip((1 - np.hypot(u, v)) * b + 0.5, 0, 1).astype(np.float32)
    pixels = np.asarray(picture)
    if rng.random() < 0.5:
        pixels, matte = pixels.swapaxes(0, 1), matte.T
    return recolored(Cutout(np.ascontiguousarray(pixels), matte), *_tint(rng))


def _occluder(rng: np.random.Generator, picture: Bytes) -> Cutout:
    """Return a piece of a picture with a wavy soft border, somewhat larger than a target."""
    side = min(CUTOUT_SIDE, *picture.shape[:2])
    top, left = rng.integers(np.array(picture.shape[:2]) - side + 1).tolist()
    axis = np.abs(np.linspace(-1, 1, side))
    depth = 0.86 - np.maximum(axis, axis[:, None]) + 0.03 * noise(rng, side, side, side / 4)
    matte = np.clip(depth * side / 4 + 0.5, 0, 1).astype(np.float32)
    return Cutout(picture[top : top + side, left : left + side].copy(), matte)


def _fitted(rng: np.random.Generator, picture: Bytes, size: tuple[int, int]) -> Bytes:
    """Return a random part of a picture, or of the picture mirrored, in a width and height."""
    height, width = picture.shape[:2]
    shrink = min(width / size[0], height / size[1])
    shrink = min(shrink, max(rng.uniform(0.6, 1) * shrink, 1.0))
    part = np.array(size) * shrink
    left, top = (rng.random(2) * np.maximum((width, height) - part, 0)).tolist()
    box = (left, top, left + part[0], top + part[1])
    image = Image.fromarray(picture).resize(size, Image.Resampling.LANCZOS, box)
    fitted = np.asarray(image)
    return np.ascontiguousarray(fitted[:, ::-1] if rng.random() < 0.5 else fitted)
