"""Rendered clips whose truth is known exactly: for the demo, for tests and for benchmarks.

A `Clip` is a garden floor, seen from close up, over which striped beetles move: elliptical
targets along known paths, in front of leaves that share some of their colors and behind plant
stems. The same clip has the same pixels every time, and any frame can be rendered on its own.
"""

from __future__ import annotations

import math
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
from motes.evaluation.synthetic.scenery import (
    SHIFTS,
    Floats,
    backdrop,
    local,
    noise,
    scale_of,
    to_bytes,
    window,
)

Color = tuple[int, int, int]
Colors = tuple[Color, Color, Color]

REACH = 1.25
"""A texture covers -REACH … REACH half-axes, so that half-covered pixels find colors too."""


class Truth(NamedTuple):
    """Where a target is, and how much of it the picture shows.

    `ellipse` is exact, also while the target is hidden or outside the frame. `visible` is the
    visible fraction of its area: 1 for all of it, 0 where it is hidden or outside.
    """

    ellipse: Ellipse
    visible: float


@dataclass(frozen=True, eq=False)
class Target:
    """A striped beetle: its ellipse in every frame and its colors.

    Attributes
    ----------
    states
        (frames, 5), of x, y, a, b, theta; the head points along a.
    colors
        RGB of the shell, its stripes and the head.
    belly
        The same of the other side, which shows where the target has rolled over.
    roll
        (frames,), how far it has rolled about its long axis, in radians; None for not at all.
    crosswise
        Whether its skin is turned by a quarter: as much of each color, and other edges.
    """

    states: NDArray[np.float64]
    colors: Colors = ((238, 196, 92), (44, 30, 26), (196, 78, 40))
    belly: Colors = ((66, 104, 186), (232, 230, 218), (36, 56, 108))
    roll: NDArray[np.float64] | None = None
    crosswise: bool = False


class Stem(NamedTuple):
    """A plant stem that hides what passes behind it, from the upper to the lower border.

    `x` is its middle in the frame's middle row, `width` is in pixels across the stem, and
    `lean` is how far it goes to the right for every row downwards.
    """

    x: float
    width: float
    lean: float = 0.0


@dataclass(frozen=True, eq=False)
class Clip:
    """A film of `targets`, later ones in front of earlier ones, behind `stems`.

    `len(clip)` is the number of frames; `clip[index]` renders a `Frame` and the `Truth` of every
    target; iterating gives all frames in order. Equal arguments give equal bytes.

    Attributes
    ----------
    size
        Width and height in pixels.
    seed
        Chooses the ground, the textures and the grain, but not the paths.
    """

    size: tuple[int, int]
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
        index = range(len(self))[index]
        (width, height), (base, cover, grain) = self.size, self._scenery
        pixels, unhidden, truths = base.copy(), 1 - cover, []
        for target, texture in zip(self.targets[::-1], self._textures[::-1], strict=True):
            ellipse = Ellipse(*target.states[index].tolist())
            truths.append(Truth(ellipse, _paint(pixels, unhidden, texture(index), ellipse)))
        dx, dy = np.random.default_rng((self.seed, 2, index)).integers(SHIFTS, size=2)
        pixels += grain[dy : dy + height, dx : dx + width]
        return Frame(index, index * FRAME_INTERVAL, pixels), tuple(truths[::-1])

    @cached_property
    def _scenery(self) -> tuple[NDArray[np.uint8], Floats, NDArray[np.uint8]]:
        return backdrop(np.random.default_rng((self.seed, 0)), self.size, self.stems)

    @cached_property
    def _textures(self) -> list[Callable[[int], Image.Image]]:
        rng = np.random.default_rng((self.seed, 1))
        return [_texture(rng, target) for target in self.targets]


def demo(size: tuple[int, int] = (640, 480), frames: int = 300, seed: int = 0) -> Clip:
    """Return the clip to judge a tracker by: one beetle meets every difficulty in 300 frames.

    It passes behind a stem (frames 58 to 69), turns and grows to twice its size, shrinks, jumps
    by more than its length (frame 200), leaves the frame on the right and returns. A longer
    clip begins again, a shorter one ends early.
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


def jumping(
    size: tuple[int, int] = (640, 480), frames: int = 200, leap: float = 1.3, seed: int = 0
) -> Clip:
    """Return a clip whose target flies to and fro, as a snowboarder, too fast to overlap itself.

    It waits, takes off, accelerates until it moves by `leap` times its width from one frame to
    the next, and lands on the other side, every 40 frames with the default leap: for 8 frames
    then its region shares no pixel with the one before.
    """
    scale = scale_of(size)
    a, b, span = 20 * scale, 14 * scale, 0.68 * size[0]
    flight, pause = span / (leap * b), 16
    turn, phase = np.divmod(np.arange(frames), math.ceil(flight) + pause)
    s = np.clip((phase - pause / 2) / flight, 0, 1)
    s -= np.sin(2 * math.pi * s) / (2 * math.pi)  # how far, 0 to 1, starting and ending at rest
    x = _center(size)[0] + span * np.where(turn % 2, 0.5 - s, s - 0.5)
    y = size[1] * 0.7 - 160 * scale * s * (1 - s)
    return Clip(size, (Target(_states(x, y, a, b, -math.pi / 2)),), seed=seed)


def turning(size: tuple[int, int] = (640, 480), frames: int = 100, seed: int = 0) -> Clip:
    """Return a clip whose target turns once around its center: 2π / frames from frame to frame."""
    theta = np.arange(frames) * 2 * math.pi / frames
    center, scale = _center(size), scale_of(size)
    return Clip(size, (Target(_states(*center, 64 * scale, 36 * scale, theta)),), seed=seed)


def rolling(size: tuple[int, int] = (640, 480), frames: int = 120, seed: int = 0) -> Clip:
    """Return a clip whose target rolls over as it walks along, until other colors are all it shows.

    It does so over the middle half of the frames, by half a turn about its long axis.
    """
    scale, (x, y) = scale_of(size), _center(size)
    along = np.linspace(-0.2, 0.2, frames) * size[0]
    roll = math.pi * np.clip(2 * np.linspace(0, 1, frames) - 0.5, 0, 1)
    states = _states(x + along, y, 56 * scale, 34 * scale, 0.0)
    return Clip(size, (Target(states, roll=roll),), seed=seed)


def growing(
    size: tuple[int, int] = (640, 480), frames: int = 100, factor: float = 4.0, seed: int = 0
) -> Clip:
    """Return a clip whose target grows until `factor` times as long and wide, and shrinks back."""
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
        If a stem that hides the target for so long leaves no room beside it.
    """
    scale = scale_of(size)
    a, speed = 24 * scale, 5 * scale
    stem = Stem(_center(size)[0], 2 * a + speed * length)
    # The target turns back `half` frames from the stem's middle; an even number of hidden frames
    # lies around that middle at half-integers, an odd one at integers.
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
    """Return a clip for benchmarks: an upright target of a width and height, hardly moving.

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
    """Return a clip for benchmarks: rows of upright targets, as many as have room to circle.

    Each goes around its place, 6 pixels away, once in all frames, so that the clip can be repeated
    without a seam. A hundred targets and some of the default size have room in the default frame.
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
    """Return the states of a walk through knots (frame, x, y, a), smoothed, head first."""
    table = np.array(knots, np.float64)
    kernel, half = np.hanning(27)[1:-1], 12
    time = np.arange(table[0, 0] - half, table[-1, 0] + half + 1)
    x, y, a = (
        np.convolve(np.interp(time, table[:, 0], column), kernel / kernel.sum(), "valid")
        for column in table.T[1:]
    )
    return _states(x, y, a, 0.7 * a, np.unwrap(np.arctan2(np.gradient(y), np.gradient(x))))


def _paint(
    pixels: NDArray[np.uint8], unhidden: Floats, texture: Image.Image, ellipse: Ellipse
) -> float:
    """Paint a target and its shadow where nothing hides them; return its visible fraction.

    `pixels` and `unhidden` (1 where targets further behind may still be seen) are changed.
    """
    small = min(ellipse.a, ellipse.b)
    part, x, y = window(ellipse, 0.6 * small + 1, unhidden.shape)
    if not unhidden[part].size:
        return 0.0
    u, v = local(x, y, ellipse)
    radius, slope = np.hypot(u, v), np.hypot(u / ellipse.a, v / ellipse.b)
    distance = (radius - 1) * radius / np.maximum(slope, 1e-6)  # to the edge, in pixels
    seen = np.clip(0.5 - distance, 0, 1) * unhidden[part]
    shadow = np.hypot(*local(x - 0.15 * small, y - 0.3 * small, ellipse))
    light = 1 - 0.5 * unhidden[part] * np.clip((1.25 - shadow) / 0.5, 0, 1)

    whole = np.array([2 * REACH * ellipse.a, 2 * REACH * ellipse.b])
    wide, high = np.rint(texture.size / whole).astype(int).clip(1).tolist()
    texture = texture.reduce((wide, high))  # else its stripes would shimmer in small targets
    # From this part of the picture to the texture, in Pillow's coordinates, which start at the
    # corner of the first pixel.
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


def _texture(rng: np.random.Generator, target: Target) -> Callable[[int], Image.Image]:
    """Return a beetle's picture by frame, over -REACH … REACH half-axes, head to the right."""
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
    around = np.arcsin(np.clip(u, -1, 1))  # by row: the angle from the middle of the upper side

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
