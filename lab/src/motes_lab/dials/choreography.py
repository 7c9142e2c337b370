"""Where everything is at each time of a film with dials.

All random numbers are drawn first, in one order: a film with another dial differs from it by this
dial alone.
"""

from __future__ import annotations

import math

import numpy as np

from motes.core.errors import ConfigError
from motes.core.geometry import Box
from motes.core.types import Floats
from motes_lab.dials.cutout import Pose
from motes_lab.dials.dials import Dials

SIDE = 48.0
"""The side of the target, the square root of its box's area, in pixels."""
SMALLEST = 8.0
"""Its side with `small` 1."""
CLEARANCE = 1.6 * SIDE
"""Distance of its center from the border; with `growth`, its side may be twice as long."""
SLOW, FAST = 0.04, 0.8
"""Largest displacement from frame to frame, in sides, with `motion` 0 and 1."""
PAN = 10.0
"""Pixels by which the camera moves to and fro."""
JUMP = 0.35
"""Standard deviation of the camera's position with `shake` 1, in sides."""
LARGEST_JUMP = 2.0
"""Its limit, in standard deviations."""
MARGIN = math.ceil(PAN + LARGEST_JUMP * JUMP * SIDE) + 2
"""Pixels of the background around the picture, on each side."""
COPIES = 4
"""Copies of the target with `distractors` 1."""
WAYS = np.array([(1, 0), (-1, 0), (0, 1), (0, -1)])
"""The directions from which something may cover the target."""


class Choreography:
    """The motion of the target, of the camera and of all else, as functions of the time in frames.

    Parameters
    ----------
    dials
        How hard the film is.
    rng
        Source of randomness.
    size
        Width and height of the picture.
    frames
        Number of frames.

    Raises
    ------
    ConfigError
        If the picture has no room for a target of twice the usual side.
    """

    def __init__(
        self, dials: Dials, rng: np.random.Generator, size: tuple[int, int], frames: int
    ) -> None:
        self.dials, self.size, self.frames = dials, size, frames
        if min(size) <= 2 * CLEARANCE:
            raise ConfigError(
                f"A film of {size[0]}x{size[1]} is too small; take {2 * CLEARANCE + 2:.0f} pixels "
                f"or more in each direction."
            )
        self._phases = rng.uniform(0, 2 * math.pi, 6)
        self._ratio = rng.uniform(0.55, 0.85)
        self._signs = rng.choice([-1, 1], 6)
        self._jumps = rng.standard_normal((frames + 1, 2)).clip(-LARGEST_JUMP, LARGEST_JUMP)
        self._orbits = rng.uniform(0, 2 * math.pi, COPIES)
        self._speeds = rng.uniform(0.7, 1.3, COPIES) * rng.choice([-1, 1], COPIES)
        self._growths = rng.uniform(-1, 1, COPIES)
        self.hues = rng.uniform(-1, 1, COPIES)
        self.shade_direction = rng.uniform(0, 2 * math.pi)
        self._way = int(rng.integers(4))
        self.side = SIDE * (SMALLEST / SIDE) ** dials.small

    def part(self, time: float) -> float:
        """Return the elapsed share of the film."""
        return time / max(self.frames - 1, 1)

    def camera(self, time: float) -> Floats:
        """Return the position (2,) of the camera on the background, around 0."""
        angle = 2 * math.pi * self.part(time) + self._phases[:2]
        position: Floats = PAN * np.sin(angle) + self.jump(time)
        return position

    def jump(self, time: float) -> Floats:
        """Return the part (2,) of the camera's position that its shaking gives."""
        first = min(int(time), self.frames - 1)
        before, after = self._jumps[first], self._jumps[first + 1]
        jumped: Floats = (before + (time - first) * (after - before)) * JUMP * self.side
        return self.dials.shake * jumped

    def target(self, time: float) -> Pose:
        """Return the target's pose, with its side in place of the factors."""
        dials = self.dials
        room = np.array(self.size) / 2 - CLEARANCE
        speed = self.side * (SLOW + (FAST - SLOW) * dials.motion)
        pace = np.array([1, self._ratio]) * speed / math.hypot(1, self._ratio) / room
        x, y = np.array(self.size) / 2 + room * np.sin(pace * time + self._phases[2:4])
        x, y = np.array([x, y]) - self.jump(time)
        grown = math.exp(
            self._signs[0] * math.log1p(3 * dials.growth) * (smooth(self.part(time)) - 0.5)
        )
        longer = math.exp(
            self._signs[1] * math.log1p(3 * dials.proportions) / 2 * smooth(self.part(time))
        )
        theta = self._signs[2] * 2 * math.pi * dials.turn * self.part(time)
        side = self.side * grown
        return Pose(float(x), float(y), side * longer, side / longer, theta)

    def roll(self, time: float) -> float:
        """Return the angle by which the target is turned about its upright axis, in radians."""
        return float(self._signs[3] * math.pi * self.dials.roll * self.part(time))

    def copies(self, time: float) -> list[Pose]:
        """Return the poses of the copies of the target, with sides in place of factors."""
        strength = self.dials.distractors
        count = round(1 + (COPIES - 1) * strength) if strength else 0
        target, poses = self.target(time), []
        for orbit, speed, growth in zip(
            self._orbits[:count], self._speeds, self._growths, strict=False
        ):
            angle = orbit + speed * 4 * math.pi * self.part(time)
            scale = math.exp(0.3 * (1 - strength) * growth)
            poses.append(
                target._replace(
                    x=target.x + 1.7 * self.side * math.cos(angle),
                    y=target.y + 0.9 * self.side * math.sin(angle + 0.6),
                    width=target.width * scale,
                    height=target.height * scale,
                )
            )
        return poses

    def light(self, time: float) -> float:
        """Return the light of the scene, 1 at the start."""
        change = smooth((self.part(time) - 0.2) / 0.3) * self.dials.light
        return 1 - 0.8 * change if self._signs[4] < 0 else 1 + 1.5 * change

    def shade(self, time: float) -> float:
        """Return how far the shade's border has passed the target, in sides."""
        return 1.5 * (2 * smooth((self.part(time) - 0.2) / 0.35) - 1) - 0.1

    def defocus(self, time: float) -> float:
        """Return the standard deviation of the blur, in pixels."""
        wave = math.sin(2 * math.pi * self.part(time)) ** 2
        return float(0.12 * self.dials.blur * self.side * wave)

    def occluder(self, time: float, box: Box) -> Pose | None:
        """Return the pose of the occluder, with its side in place of the factors, or None.

        It covers the share `occlusion` of the target's box.
        """
        part = self.part(time)
        come = min(smooth((part - 0.3) / 0.1), smooth((0.75 - part) / 0.1))
        covered = self.dials.occlusion * come
        if not covered:
            return None
        side = 1.3 * max(box.width, box.height)
        target, way = self.target(time), WAYS[self._way]
        size = np.array(box[2:])
        # If it covers nothing, its edge is at the edge of the box.
        away = way * ((side + size) / 2 - covered * size)
        return Pose(target.x + float(away[0]), target.y + float(away[1]), side, side)


def smooth(part: float) -> float:
    """Return a smooth step from 0 to 1, for a part from 0 to 1."""
    part = min(max(part, 0.0), 1.0)
    return part * part * (3 - 2 * part)
