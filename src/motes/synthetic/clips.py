"""Rendered clips with exactly known truth: for the demo, for tests and for benchmarks.

A `Clip` shows a garden floor from close up, on which striped beetles walk. They are elliptical
targets on known paths, in front of leaves with some of the same colors, and behind plant stems. The
same clip always has the same pixels, and any frame can be rendered alone.
"""

from __future__ import annotations

import math
import operator
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray
from PIL import Image

from motes.core.errors import ConfigError
from motes.core.frame import FRAME_INTERVAL, Frame
from motes.core.geometry import Ellipse
from motes.synthetic.beetle import Target, paint, texture_of
from motes.synthetic.scenery import SHIFTS, Floats, backdrop, scale_of


class Truth(NamedTuple):
    """The position of a target, and its visible fraction.

    `ellipse` is exact, also while the target is hidden or outside the frame. `visible` is the
    visible fraction of its area: 1 if all of it is visible, 0 if it is hidden or outside.
    """

    ellipse: Ellipse
    visible: float


class Stem(NamedTuple):
    """A plant stem that hides targets behind it, from the upper to the lower border.

    `x` is its middle in the frame's middle row, `width` is in pixels across the stem, and `lean` is
    its shift to the right for every row downwards.
    """

    x: float
    width: float
    lean: float = 0.0


@dataclass(frozen=True, eq=False)
class Clip:
    """A video of `targets`, later ones in front of earlier ones, behind `stems`.

    `len(clip)` is the number of frames; `clip[index]` renders a `Frame` and the `Truth` of every
    target; iterating gives all frames in order. Equal arguments give equal bytes.

    Attributes
    ----------
    seed
        Determines the ground, the textures and the grain, but not the paths.
    """

    size: tuple[int, int]
    """Width and height in pixels."""
    targets: tuple[Target, ...]
    stems: tuple[Stem, ...] = ()
    seed: int = 0

    def __post_init__(self) -> None:
        if min(self.size) < 32:
            raise ConfigError(f"A clip of {self.size[0]}x{self.size[1]} is too small; take 32x32.")
        if not len(self):
            raise ConfigError("A clip without frames cannot be rendered; ask for 1 or more.")

    def __len__(self) -> int:
        return len(self.targets[0].states)

    def __iter__(self) -> Iterator[tuple[Frame, tuple[Truth, ...]]]:
        return (self[index] for index in range(len(self)))

    def __getitem__(self, index: int) -> tuple[Frame, tuple[Truth, ...]]:
        index = range(len(self))[operator.index(index)]
        (width, height), (base, cover, grain) = self.size, self._scenery
        pixels, unhidden, truths = base.copy(), 1 - cover, []
        for target, texture in zip(self.targets[::-1], self._textures[::-1], strict=True):
            ellipse = Ellipse(*target.states[index].tolist())
            truths.append(Truth(ellipse, paint(pixels, unhidden, texture(index), ellipse)))
        dx, dy = np.random.default_rng((self.seed, 2, index)).integers(SHIFTS, size=2)
        pixels += grain[dy : dy + height, dx : dx + width]
        return Frame(index, index * FRAME_INTERVAL, pixels), tuple(truths[::-1])

    @cached_property
    def _scenery(self) -> tuple[NDArray[np.uint8], Floats, NDArray[np.uint8]]:
        return backdrop(self.seed, tuple(self.size), tuple(self.stems))

    @cached_property
    def _textures(self) -> list[Callable[[int], Image.Image]]:
        rng = np.random.default_rng((self.seed, 1))
        return [texture_of(rng, target) for target in self.targets]


def demo(size: tuple[int, int] = (640, 480), frames: int = 300, seed: int = 0) -> Clip:
    """Return the demo clip: one beetle meets every difficulty in 300 frames.

    It passes behind a stem (frames 58 to 69), turns and grows to twice its size, shrinks, jumps by
    more than its length (frame 200), leaves the frame on the right and returns. A longer clip
    starts again, a shorter one ends early.
    """
    scale = scale_of(size)
    behind_the_stem = (0, 90, 350, 36), (40, 210, 300, 32), (90, 430, 272, 32)
    turn = (118, 545, 215, 46), (140, 560, 330, 68), (160, 470, 390, 72), (180, 420, 310, 50)
    out = (200, 545, 180, 36), (212, 590, 160, 36), (232, 720, 170, 36)
    back = (244, 720, 290, 36), (268, 575, 320, 38), (299, 440, 360, 38)
    states = np.concatenate(
        [_glide(*behind_the_stem, *turn, (199, 452, 250, 36)), _glide(*out, *back)]
    )
    states[:, :2] *= np.array(size) / (640, 480)
    states[:, 2:4] *= scale
    return Clip(
        size,
        (Target(states[np.arange(frames) % len(states)]),),
        (Stem(316 * size[0] / 640, 117 * scale, -0.08),),
        seed,
    )


def jumping(size: tuple[int, int] = (640, 480), frames: int = 200, seed: int = 0) -> Clip:
    """Return a clip whose target jumps to and fro like a snowboarder, too fast to overlap itself.

    It waits, takes off, accelerates until it moves by 1.3 times its width from one frame to the
    next, and lands on the other side. This takes 40 frames, and for 8 of them the region shares no
    pixel with the one before.
    """
    scale = scale_of(size)
    a, b, span = 20 * scale, 14 * scale, 0.68 * size[0]
    flight, pause = span / (1.3 * b), 16
    turn, phase = np.divmod(np.arange(frames), math.ceil(flight) + pause)
    s = np.clip((phase - pause / 2) / flight, 0, 1)
    s -= np.sin(2 * math.pi * s) / (2 * math.pi)  # position from 0 to 1; at rest at both ends
    x = _center(size)[0] + span * np.where(turn % 2, 0.5 - s, s - 0.5)
    y = size[1] * 0.7 - 160 * scale * s * (1 - s)
    return Clip(size, (Target(_states(x, y, a, b, -math.pi / 2)),), seed=seed)


def turning(size: tuple[int, int] = (640, 480), frames: int = 100, seed: int = 0) -> Clip:
    """Return a clip whose target rotates once around its center, by 2π / frames in each frame."""
    theta = np.arange(frames) * 2 * math.pi / frames
    center, scale = _center(size), scale_of(size)
    return Clip(size, (Target(_states(*center, 64 * scale, 36 * scale, theta)),), seed=seed)


def rolling(size: tuple[int, int] = (640, 480), frames: int = 120, seed: int = 0) -> Clip:
    """Return a clip whose target walks and rolls over, until only its other colors are visible.

    The roll takes the middle half of the frames and is half a turn about the long axis.
    """
    scale, (x, y) = scale_of(size), _center(size)
    along = np.linspace(-0.2, 0.2, frames) * size[0]
    roll = math.pi * np.clip(2 * np.linspace(0, 1, frames) - 0.5, 0, 1)
    states = _states(x + along, y, 56 * scale, 34 * scale, 0.0)
    return Clip(size, (Target(states, roll=roll),), seed=seed)


def growing(
    size: tuple[int, int] = (640, 480), frames: int = 100, factor: float = 4.0, seed: int = 0
) -> Clip:
    """Return a clip whose target grows to `factor` times its length and width, and shrinks back."""
    growth = factor ** (0.5 - 0.5 * np.cos(np.arange(frames) * 2 * math.pi / frames))
    growth *= scale_of(size)
    return Clip(size, (Target(_states(*_center(size), 28 * growth, 20 * growth, 0.4)),), seed=seed)


def occluded(
    size: tuple[int, int] = (640, 480), frames: int = 250, length: int = 12, seed: int = 0
) -> Clip:
    """Return a clip whose target passes to and fro behind a stem, hidden for `length` frames.

    Raises
    ------
    ConfigError
        If a stem of the necessary width leaves no room beside it.
    """
    scale = scale_of(size)
    a, speed = 24 * scale, 5 * scale
    stem = Stem(_center(size)[0], 2 * a + speed * length)
    # The target turns back `half` frames from the stem's middle. With an even number of hidden
    # frames, that middle lies between two frames; with an odd number, on a frame.
    half = math.floor((size[0] / 2 - 2 * a) / speed) - (length + 1) % 2 / 2
    if speed * half < stem.width / 2 + 2 * a:
        raise ConfigError(
            f"No stem in a frame of {size[0]}x{size[1]} hides the target for {length} frames; "
            f"choose a shorter occlusion or a wider frame."
        )
    x = stem.x + speed * (half - np.abs(np.arange(frames) % (4 * half) - 2 * half))
    return Clip(size, (Target(_states(x, _center(size)[1], a, 17 * scale, 0.0)),), (stem,), seed)


def crossing(size: tuple[int, int] = (640, 480), frames: int = 120, seed: int = 0) -> Clip:
    """Return a clip of two similar targets that meet in the middle; the second walks in front."""
    scale, (x, y) = scale_of(size), _center(size)
    offset = np.linspace(-0.38, 0.38, frames) * size[0]
    a, b = 34 * scale, 24 * scale
    behind = _states(x - offset, y - 8 * scale, a, b, math.pi)
    front = _states(x + offset, y + 8 * scale, a, b, 0.0)
    colors = (228, 176, 100), (58, 34, 26), (178, 60, 44)
    return Clip(size, (Target(behind), Target(front, colors)), seed=seed)


def still(
    size: tuple[int, int] = (640, 480),
    target: tuple[float, float] = (60, 100),
    frames: int = 100,
    seed: int = 0,
) -> Clip:
    """Return a clip for benchmarks: an upright target of a width and height, nearly at rest.

    It circles around the frame's center, 6 pixels away, once in 100 frames.
    """
    angle = np.arange(frames) * 2 * math.pi / 100
    x, y = _center(size)
    states = _states(
        x + 6 * np.cos(angle), y + 6 * np.sin(angle), target[1] / 2, target[0] / 2, -math.pi / 2
    )
    return Clip(size, (Target(states),), seed=seed)


def crowd(
    size: tuple[int, int] = (1920, 1080),
    target: tuple[float, float] = (60, 100),
    frames: int = 20,
    seed: int = 0,
) -> Clip:
    """Return a clip for benchmarks: rows of upright targets, as many as fit.

    Each target circles 6 pixels around its position, once in all frames, so that the clip can be
    repeated without a jump. More than a hundred targets of the default size fit into the default
    frame.
    """
    columns, rows = int(size[0] / (2 * target[0])), int(size[1] / (1.5 * target[1]))
    angle = np.arange(frames) * 2 * math.pi / frames
    circling = [
        _states(
            size[0] * (i % columns + 0.5) / columns + 6 * np.cos(angle),
            size[1] * (i // columns + 0.5) / rows + 6 * np.sin(angle),
            target[1] / 2, target[0] / 2, -math.pi / 2,
        )
        for i in range(columns * rows)
    ]  # fmt: skip
    return Clip(size, tuple(map(Target, circling)), seed=seed)


def _center(size: tuple[int, int]) -> tuple[float, float]:
    return (size[0] - 1) / 2, (size[1] - 1) / 2


def _states(*columns: ArrayLike) -> NDArray[np.float64]:
    """Return x, y, a, b and theta, numbers or one value per frame, as (frames, 5)."""
    return np.stack(np.broadcast_arrays(*columns), axis=1).astype(np.float64)


def _glide(*knots: tuple[int, int, int, int]) -> NDArray[np.float64]:
    """Return the states of a smooth walk through knots (frame, x, y, a), head first."""
    table = np.array(knots, np.float64)
    kernel, half = np.hanning(27)[1:-1], 12
    time = np.arange(table[0, 0] - half, table[-1, 0] + half + 1)
    x, y, a = (
        np.convolve(np.interp(time, table[:, 0], column), kernel / kernel.sum(), "valid")
        for column in table.T[1:]
    )
    return _states(x, y, a, 0.7 * a, np.unwrap(np.arctan2(np.gradient(y), np.gradient(x))))
