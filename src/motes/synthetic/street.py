"""A street seen from the other side: cars in two directions, a parked lorry that hides some."""

from __future__ import annotations

from functools import cached_property
from typing import NamedTuple

import numpy as np
from PIL import Image

from motes.core.geometry import Box
from motes.synthetic.painted_film import FINE, Brush, Color, PaintedFilm, textured

GLASS, TIRE, RIM = (148, 166, 182), (30, 30, 32), (150, 150, 152)
WALLS = (196, 172, 146), (178, 146, 120), (160, 156, 148)
LORRY = Box(268, 118, 118, 118)
"""Where the parked lorry stands."""


class Lane(NamedTuple):
    """A lane: where wheels touch the road, the length of a car, and the way that cars go."""

    foot: float
    length: float
    way: int


REACH = 8
"""Pixels outside of a car's box that its shadow may reach."""
FAR, NEAR = Lane(158, 66, -1), Lane(206, 88, 1)


class Car(NamedTuple):
    """A car."""

    lane: Lane
    """Where it drives."""
    enters: float
    """The frame in which its front comes into the picture; before the first frame if negative."""
    speed: float
    """In pixels a frame."""
    color: Color
    """Of its body."""
    high: float = 0.36
    """Height as a share of its length: a saloon, or a van."""

    def box(self, time: float, width: float) -> Box:
        """Return its box at a time, in a picture of a width."""
        length, gone = self.lane.length, self.speed * (time - self.enters)
        left = gone - length if self.lane.way > 0 else width - gone
        return Box(left, self.lane.foot - self.high * length, length, self.high * length)


class Street(PaintedFilm):
    """Eight cars, the first of which passes behind a parked lorry; a cloud dims the light."""

    cars = (
        Car(NEAR, -28, 3.4, (176, 38, 34)),
        Car(FAR, -62, 3.6, (206, 208, 210)),
        Car(FAR, 6, 3.1, (44, 74, 128), 0.46),
        Car(NEAR, 52, 3.9, (28, 30, 44)),
        Car(FAR, 70, 4.4, (196, 160, 54)),
        Car(NEAR, 96, 3.5, (222, 222, 216), 0.48),
        Car(FAR, 112, 3.3, (36, 40, 46)),
        Car(NEAR, 146, 4.6, (60, 110, 76)),
    )

    def boxes(self, time: float) -> list[Box]:
        """Return the boxes of the cars."""
        return [car.box(time, self.size[0]) for car in self.cars]

    def depths(self, time: float) -> list[float]:
        """Return where their wheels are."""
        return [car.lane.foot for car in self.cars]

    def covers(self, time: float) -> list[Box]:
        """Return the lorry's box."""
        return [LORRY]

    def light(self, index: int) -> float:
        """Return the light: a cloud passes."""
        return 1 - 0.25 * float(np.clip(min(index - 100, 170 - index) / 15, 0, 1))

    def picture(self, time: float) -> Image.Image:
        """Return the street at a time."""
        image = self._backdrop.copy()
        brush = Brush(image)
        for car in sorted(self.cars, key=lambda car: car.lane.foot):
            box = car.box(time, self.size[0])
            if -box.width - REACH < box.x < self.size[0] + REACH:
                _paint(brush, car, box)
        lorry, left, top = self._lorry, FINE * (LORRY.x - 8), FINE * LORRY.y
        image.paste(lorry, (round(left), round(top)), lorry)
        return image

    @cached_property
    def _backdrop(self) -> Image.Image:
        width, height = self.size
        rng = np.random.default_rng((self.seed, 0))
        image = Image.new("RGB", (FINE * width, FINE * height), (112, 110, 106))
        brush, x = Brush(image), 0.0
        while x < width:  # houses
            wide = float(rng.integers(70, 110))
            wall = tuple(
                (rng.uniform(0.6, 1.0) * np.array(WALLS[rng.integers(3)])).astype(int).tolist()
            )
            brush.polygon([(x, 0), (x + wide, 0), (x + wide, 108), (x, 108)], wall)
            for row in (8, 56):
                for column in np.arange(x + 10, x + wide - 18, 24).tolist():
                    brush.box(column, row, column + 13, row + 26, (214, 208, 196))
                    pane = tuple((rng.integers(30, 80) * np.ones(3, int)).tolist())
                    brush.box(column + 2, row + 2, column + 11, row + 24, pane)
            x += wide
        brush.polygon([(0, 108), (width, 108), (width, 128), (0, 128)], (150, 146, 138))
        brush.polygon([(0, 126), (width, 126), (width, 129), (0, 129)], (96, 94, 90))
        brush.polygon([(0, 129), (width, 129), (width, 232), (0, 232)], (84, 85, 88))
        for left in range(0, width, 48):
            brush.polygon(
                [(left, 176), (left + 26, 176), (left + 25, 178), (left - 1, 178)], (196, 194, 186)
            )
        brush.polygon([(0, 232), (width, 232), (width, 236), (0, 236)], (170, 166, 158))
        return textured(image, rng, 0.05)

    @cached_property
    def _lorry(self) -> Image.Image:
        _, _, wide, high = LORRY
        image = Image.new("RGBA", (round(FINE * (wide + 16)), round(FINE * (high + 6))))
        brush, x, y = Brush(image), 8.0, 0.0
        brush.ellipse(x - 4, y + high - 10, x + wide + 6, y + high + 4, (0, 0, 0, 110))
        brush.box(x, y, x + 0.74 * wide, y + high - 14, (206, 196, 168))
        brush.box(x + 6, y + 28, x + 0.68 * wide, y + 52, (70, 112, 120))
        brush.box(x + 0.76 * wide, y + 30, x + wide, y + high - 12, (92, 104, 120))
        brush.box(x + 0.84 * wide, y + 36, x + wide - 3, y + 62, GLASS)
        brush.box(x, y + high - 18, x + wide, y + high - 10, (60, 60, 62))
        for middle in (0.16, 0.32, 0.87):
            _wheel(brush, x + middle * wide, y + high, 11)
        return image


def _paint(brush: Brush, car: Car, box: Box) -> None:
    """Paint a car with its shadow."""
    x, y, wide, high = box
    ahead = car.lane.way

    def at(along: float, up: float) -> tuple[float, float]:
        """Return a point, from the rear to the front and from the road to the roof."""
        return (x + along * wide if ahead > 0 else x + (1 - along) * wide), y + (1 - up) * high

    low, dark = 0.12, tuple(round(0.72 * value) for value in car.color)
    brush.ellipse(x - 3, y + 0.88 * high, x + wide + 7, y + 1.1 * high, (0, 0, 0, 120))
    front = (0.66, 1.0), (0.80, 0.62), (0.97, 0.52)
    van = (0.80, 1.0), (0.92, 0.55), (0.98, 0.48)
    roof = van if car.high > 0.4 else front
    rear = ((0.02, 0.95),) if car.high > 0.4 else ((0.02, 0.6), (0.14, 0.66), (0.28, 1.0))
    brush.polygon([at(0, low), *(at(*p) for p in (*rear, *roof)), at(1, low)], car.color)
    brush.polygon([at(0, low), at(0, 0.3), at(1, 0.3), at(1, low)], dark)
    end = roof[0][0]
    for left, right in ((0.3, 0.5), (0.53, end + 0.08)):
        pane = (left - 0.05, 0.64), (left, 0.93), (min(right, end), 0.93), (right, 0.64)
        brush.polygon([at(*p) for p in pane], GLASS)
    headlight = (0.955, 0.36), (0.955, 0.48), (0.985, 0.46), (0.99, 0.36)
    brush.polygon([at(*p) for p in headlight], (250, 240, 200))
    rear_light = (0.005, 0.4), (0.01, 0.52), (0.035, 0.54), (0.03, 0.4)
    brush.polygon([at(*p) for p in rear_light], (150, 20, 20))
    for middle in (0.2, 0.8):
        _wheel(brush, *at(middle, 0), 0.095 * wide)


def _wheel(brush: Brush, x: float, foot: float, radius: float) -> None:
    """Paint a wheel that stands on the road."""
    for size, color in ((1.0, TIRE), (0.55, RIM)):
        half, y = size * radius, foot - radius
        brush.ellipse(x - half, y - half, x + half, y + half, color)
