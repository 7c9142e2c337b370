"""A rendered film in which first the colors of a target are useless, then its edges."""

from __future__ import annotations

from collections.abc import Iterator
from enum import Enum
from typing import NamedTuple

import numpy as np

from motes.core.frame import Frame
from motes.core.geometry import Ellipse
from motes.core.types import Bytes
from motes.synthetic.beetle import Target
from motes.synthetic.clips import Clip

SIZE = (320, 240)
FRAMES_OF_PART = 30


class FilmPart(Enum):
    """A part of the film: which of the cues color and orientation are useful in it."""

    CLEAR = "both are useful"
    BLUE_LIGHT = "color is useless"
    FROSTED_GLASS = "orientation is useless"


PARTS = (FilmPart.CLEAR, FilmPart.BLUE_LIGHT, FilmPart.CLEAR, FilmPart.FROSTED_GLASS)
"""The parts of the film in order, each of `FRAMES_OF_PART` frames."""


class Shot(NamedTuple):
    """A frame of the film, its part, and the target in it."""

    frame: Frame
    part: FilmPart
    target: Ellipse


def failing_cues(seed: int = 0) -> Iterator[Shot]:
    """Yield the film: a target walks in small bows, and turns a little."""
    t = np.arange(len(PARTS) * FRAMES_OF_PART)
    x, y = SIZE[0] / 2 + 40 * np.sin(t / 20), SIZE[1] / 2 + 20 * np.cos(t / 13)
    columns = np.broadcast_arrays(x, y, 40.0, 24.0, 0.3 * np.sin(t / 15))
    clip = Clip(SIZE, (Target(np.stack(columns, axis=1)),), seed=seed)
    for frame, (truth,) in clip:
        part, pixels = PARTS[frame.index // FRAMES_OF_PART], frame.pixels
        if part is FilmPart.BLUE_LIGHT:
            pixels = blue_light(pixels)
        if part is FilmPart.FROSTED_GLASS:
            pixels = frosted_glass(pixels, np.random.default_rng((seed, frame.index)))
        yield Shot(Frame(frame.index, frame.time, pixels), part, truth.ellipse)


def blue_light(pixels: Bytes) -> Bytes:
    """Return a picture (H, W, 3) without red and full of blue; green has the mean of all three.

    No pixel keeps its color. The contrast of edges is raised, since green is a part of gray.
    """
    lit = np.zeros_like(pixels)
    lit[..., 1] = np.rint(np.clip(1.6 * (pixels.mean(axis=2) - 100) + 128, 0, 255))
    lit[..., 2] = 255
    return lit


def frosted_glass(pixels: Bytes, rng: np.random.Generator, reach: int = 4) -> Bytes:
    """Return a picture (H, W, 3) of which each pixel is another one, up to `reach` away.

    Regions keep their colors; their edges have all orientations.
    """
    height, width = pixels.shape[:2]
    y, x = np.mgrid[:height, :width]
    y += rng.integers(-reach, reach + 1, y.shape)
    x += rng.integers(-reach, reach + 1, x.shape)
    glass: Bytes = pixels[y.clip(0, height - 1), x.clip(0, width - 1)]
    return glass
