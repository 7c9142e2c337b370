"""Painted films that look like users' own: a lens, a shutter, light that changes, and noise."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Iterator, Sequence
from functools import cached_property

import numpy as np
from PIL import Image, ImageDraw

from motes.core.frame import FRAME_INTERVAL, Frame
from motes.core.geometry import Box, Ellipse, intersection
from motes.core.types import Singles
from motes.synthetic.clips import Truth
from motes.synthetic.scenery import SHIFTS, noise, to_bytes

Color = tuple[int, ...]
"""RGB, or RGB and opacity."""
Point = tuple[float, float]

FINE = 2
"""Films are painted this many times finer, and averaged: edges are then as soft as a lens's."""
SHUTTER = -0.25, 0.0, 0.25
"""Times of the pictures that are averaged into a frame: the shutter is open for half of it."""
GRAIN = 3.0
"""Standard deviation of the noise, in gray levels."""
ROUND = 3.0
"""Largest radius of a box's corners, in pixels."""
VIGNETTE = 0.25
"""Share of the light that is lost in the corners."""


class Brush:
    """Paints in pixels of the film on a picture that is `FINE` times finer.

    The picture is changed; its left border lies at `left` in the scene, in pixels of the film.
    """

    def __init__(self, image: Image.Image, left: float = 0.0) -> None:
        self._pen, self._left = ImageDraw.Draw(image, "RGBA"), left

    def polygon(self, points: Sequence[Point], color: Color) -> None:
        """Fill a polygon."""
        self._pen.polygon(self._fine(*points), color)

    def ellipse(self, left: float, top: float, right: float, bottom: float, color: Color) -> None:
        """Fill an ellipse in a box."""
        self._pen.ellipse(self._fine((left, top), (right, bottom)), color)

    def box(self, left: float, top: float, right: float, bottom: float, color: Color) -> None:
        """Fill a box with round corners."""
        radius = min(0.25 * FINE * min(right - left, bottom - top), ROUND * FINE)
        self._pen.rounded_rectangle(self._fine((left, top), (right, bottom)), radius, color)

    def line(self, points: Sequence[Point], width: float, color: Color) -> None:
        """Draw a line."""
        self._pen.line(self._fine(*points), color, round(FINE * width))

    def ring(self, left: float, top: float, right: float, bottom: float, color: Color) -> None:
        """Draw the outline of an ellipse."""
        self._pen.ellipse(
            self._fine((left, top), (right, bottom)), outline=color, width=round(1.5 * FINE)
        )

    def _fine(self, *points: Point) -> list[Point]:
        return [(FINE * (x - self._left), FINE * y) for x, y in points]


class PaintedFilm(ABC):
    """A painted film with exact truth.

    `len(film)` is the number of frames; `film[index]` renders a `Frame` and the truth of every
    object; iterating gives all frames in order. Equal arguments give equal bytes.

    Attributes
    ----------
    size
        Width and height in pixels.
    frames
        Number of frames.
    seed
        Determines textures and noise, but not the paths.
    """

    size = (480, 270)
    frames = 200

    def __init__(self, seed: int = 0) -> None:
        self.seed = seed

    def __len__(self) -> int:
        return self.frames

    def __iter__(self) -> Iterator[tuple[Frame, tuple[Truth, ...]]]:
        return (self[index] for index in range(len(self)))

    def __getitem__(self, index: int) -> tuple[Frame, tuple[Truth, ...]]:
        index = range(len(self))[index]
        total = np.zeros((self.size[1], self.size[0], 3), np.uint16)
        for shift in SHUTTER:
            total += np.asarray(self.picture(index + shift).reduce(FINE))
        mean: Singles = total * (self.light(index) / len(SHUTTER) * self._vignette)
        dx, dy = np.random.default_rng((self.seed, 2, index)).integers(SHIFTS, size=2)
        mean += self._grain[dy : dy + self.size[1], dx : dx + self.size[0]]
        return Frame(index, index * FRAME_INTERVAL, to_bytes(mean)), self.truths(index)

    @abstractmethod
    def picture(self, time: float) -> Image.Image:
        """Return the scene at a time in frames, `FINE` times finer than the film."""

    @abstractmethod
    def boxes(self, time: float) -> list[Box]:
        """Return the boxes of all objects at a time, in the film's pixels."""

    @abstractmethod
    def depths(self, time: float) -> list[float]:
        """Return the depth of each object: what has a larger one is in front."""

    def covers(self, time: float) -> list[Box]:
        """Return boxes of what stands in front of all objects."""
        return []

    def light(self, index: int) -> float:
        """Return the light of a frame, 1 at the start."""
        return 1.0

    def truths(self, index: int) -> tuple[Truth, ...]:
        """Return the truth of all objects.

        What is visible of one is the share of its box that no box in front of it covers, and that
        is in the picture.
        """
        boxes, depths, covers = self.boxes(index), self.depths(index), self.covers(index)
        picture, truths = Box(0, 0, *self.size), []
        for box, depth in zip(boxes, depths, strict=True):
            front = [other for other, d in zip(boxes, depths, strict=True) if d > depth]
            inside, *others = intersection(np.array([box]), np.array([picture, *front, *covers]))
            visible = max(inside - max(others, default=0.0), 0.0) / (box.width * box.height)
            truths.append(Truth(Ellipse.from_box(box), float(visible)))
        return tuple(truths)

    @cached_property
    def _vignette(self) -> Singles:
        width, height = self.size
        x, y = np.linspace(-1, 1, width), np.linspace(-1, 1, height)[:, None]
        return (1 - VIGNETTE * ((x**2 + y**2) / 2) ** 2).astype(np.float32)[:, :, None]

    @cached_property
    def _grain(self) -> Singles:
        rng = np.random.default_rng((self.seed, 1))
        shape = self.size[1] + SHIFTS, self.size[0] + SHIFTS, 3
        grain: Singles = np.float32(GRAIN) * rng.standard_normal(shape, np.float32)
        return grain


def textured(image: Image.Image, rng: np.random.Generator, strength: float) -> Image.Image:
    """Return a fine picture whose brightness varies by a share, as that of real surfaces does."""
    shade = 1 + strength * noise(rng, image.width, image.height, 24)
    return Image.fromarray(to_bytes(np.asarray(image, np.float32) * shade[:, :, None]))
