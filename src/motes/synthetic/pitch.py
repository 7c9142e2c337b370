"""A match from the stand: players of two teams, all of a team alike, and a camera that pans."""

from __future__ import annotations

import math
from functools import cached_property
from typing import NamedTuple

import numpy as np
from PIL import Image

from motes.core.geometry import Box
from motes.synthetic.painted_film import FINE, Brush, Color, PaintedFilm, textured

HEIGHT, WIDTH = 46.0, 20.0
"""Of a player, in pixels."""
MARGIN = 110
"""Pixels of the pitch beyond the picture, on each side."""
RED, WHITE, BLUE, NAVY = (186, 36, 40), (226, 226, 224), (44, 84, 168), (30, 34, 66)
SKINS = (226, 180, 150), (150, 104, 78), (96, 66, 50)


class Player(NamedTuple):
    """A player, who runs on a curve."""

    x: float
    y: float
    """The middle of the curve; y is where feet are."""
    reach: tuple[float, float]
    """How far the curve goes to each side, and up and down."""
    pace: float
    """How fast the curve is run through, in radians a frame."""
    phase: float
    """Where it begins, in radians."""
    jersey: Color
    shorts: Color
    skin: Color
    """Colors."""

    def feet(self, time: float) -> tuple[float, float]:
        """Return where the feet are on the pitch."""
        angle = self.phase + self.pace * time
        return (
            self.x + self.reach[0] * math.sin(angle),
            self.y + self.reach[1] * math.sin(1.7 * angle + self.phase),
        )


def _team(jersey: Color, shorts: Color, places: tuple[tuple[float, ...], ...]) -> list[Player]:
    return [
        Player(x, y, (wide, high), pace, phase, jersey, shorts, SKINS[n % 3])
        for n, (x, y, wide, high, pace, phase) in enumerate(places)
    ]


class Pitch(PaintedFilm):
    """Ten players of two teams; the first runs past others of his team."""

    players = (
        *_team(
            RED,
            WHITE,
            (
                (250, 176, 130, 22, 0.026, -1.2),
                (180, 150, 50, 10, 0.021, 0.6),
                (330, 192, 60, 16, -0.024, 0.2),
                (90, 214, 60, 14, 0.03, 2.0),
                (420, 146, 50, 12, 0.02, 1.0),
            ),
        ),
        *_team(
            BLUE,
            NAVY,
            (
                (290, 164, 90, 20, -0.028, 2.4),
                (140, 190, 70, 18, 0.025, -0.4),
                (380, 226, 60, 10, 0.022, 0.9),
                (220, 236, 80, 12, -0.02, 1.8),
                (470, 186, 70, 16, 0.026, -2.2),
            ),
        ),
    )

    def pan(self, time: float) -> float:
        """Return by how much the camera has turned to the right, in pixels."""
        return 60 * math.sin(2 * math.pi * time / self.frames)

    def boxes(self, time: float) -> list[Box]:
        """Return the boxes of the players."""
        feet = [player.feet(time) for player in self.players]
        return [Box(x - self.pan(time) - WIDTH / 2, y - HEIGHT, WIDTH, HEIGHT) for x, y in feet]

    def depths(self, time: float) -> list[float]:
        """Return where their feet are."""
        return [player.feet(time)[1] for player in self.players]

    def picture(self, time: float) -> Image.Image:
        """Return the pitch at a time."""
        corner = round(FINE * (self.pan(time) + MARGIN))
        width, height = FINE * self.size[0], FINE * self.size[1]
        image = self._backdrop.crop((corner, 0, corner + width, height))
        brush = Brush(image, corner / FINE - MARGIN)
        for player in sorted(self.players, key=lambda player: player.feet(time)[1]):
            _paint(brush, player, time)
        return image

    @cached_property
    def _backdrop(self) -> Image.Image:
        width, height = self.size[0] + 2 * MARGIN, self.size[1]
        rng = np.random.default_rng((self.seed, 0))
        image = Image.new("RGB", (FINE * width, FINE * height), (52, 50, 54))
        brush = Brush(image)
        for _ in range(1600):  # the stand opposite
            x, y = (rng.random(2) * (width, 62)).tolist()
            coat = tuple(rng.integers(30, 190, 3).tolist())
            brush.ellipse(x, y, x + 6, y + 7, coat)
        for n, x in enumerate(range(0, width, 87)):  # boards
            board = ((196, 190, 60), (40, 70, 130), (180, 60, 60), (220, 220, 220))[n % 4]
            brush.polygon([(x, 66), (x + 86, 66), (x + 86, 84), (x, 84)], board)
            brush.polygon([(x + 14, 72), (x + 70, 72), (x + 70, 78), (x + 14, 78)], (30, 30, 34))
        for n, x in enumerate(range(-60, width + 60, 60)):  # mown stripes
            grass = (70, 122, 58) if n % 2 else (80, 136, 66)
            brush.polygon([(x + 30, 84), (x + 90, 84), (x + 60, height), (x, height)], grass)
        brush.line([(0, 98), (width, 98)], 2, WHITE)
        middle = width / 2
        brush.line([(middle + 20, 98), (middle - 10, height)], 2, WHITE)
        brush.ring(middle - 80, 150, middle + 90, 220, WHITE)
        return textured(image, rng, 0.06)


def _paint(brush: Brush, player: Player, time: float) -> None:
    """Paint a player who runs, with a shadow."""
    x, y = player.feet(time)
    ahead, _ = player.feet(time + 0.5)
    way, stride = math.copysign(1, ahead - x), 0.42 * time + 5 * player.phase
    swing, top = 6 * math.sin(stride), y - HEIGHT
    brush.ellipse(x - 6, y - 4, x + 22, y + 3, (0, 20, 0, 90))
    for leg in (1, -1):
        knee = x + leg * 0.6 * swing, y - 11 - 1.5 * abs(math.cos(stride))
        foot = x + leg * swing - way, y - 1.5 * (leg * math.cos(stride) * way > 0) - 1
        brush.line([(x, y - 19), knee], 4.5, player.skin)
        brush.line([knee, foot], 4, player.jersey)  # socks
    brush.box(x - 6, y - 25, x + 6, y - 15, player.shorts)
    brush.box(x - 7, top + 8, x + 7, y - 22, player.jersey)
    for arm in (1, -1):
        elbow = x + arm * 8, top + 18
        hand = elbow[0] - arm * 1 + way * arm * 0.6 * swing, top + 24
        brush.line([(x + arm * 6, top + 10), elbow], 4, player.jersey)
        brush.line([elbow, hand], 3, player.skin)
    brush.box(x - 3, top + 12, x + 3, top + 19, player.shorts)  # the number
    brush.ellipse(x - 4, top, x + 4, top + 9, player.skin)
    brush.ellipse(x - 4 - 0.5 * way, top - 1, x + 4 - 0.5 * way, top + 4, (50, 36, 28))
