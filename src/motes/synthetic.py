"""Rendered clips whose truth is known exactly: for the demo, for tests and for benchmarks.

A `Clip` is a garden floor, seen from close up, over which striped beetles move: elliptical
targets along known paths, in front of leaves that share some of their colors and behind plant
stems. The same clip has the same pixels every time, and any frame can be rendered on its own.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray
from PIL import Image, ImageFilter

from motes.errors import ConfigError
from motes.frame import FRAME_INTERVAL, Frame
from motes.geometry import Ellipse

Floats = NDArray[Any]
"""Values of float32: numpy keeps them so in arithmetic with Python's own numbers."""
Color = tuple[int, int, int]

GRAIN = 14
"""The film grain's largest value, of 255; the scene keeps this far from black and white."""
SHIFTS = 64
"""The grain is one noise picture, moved by 0 … 63 pixels in x and in y from frame to frame."""
REACH = 1.25
"""A texture covers -REACH … REACH half-axes, so that half-covered pixels find colors too."""
LEAVES = np.frombuffer(
    bytes.fromhex("7a5838 9e7a50 60422c 68703a 486232 58763c 3c522e 807a6e c49e46 96502e b6a27a"),
    np.uint8,
).reshape(-1, 3)
"""Their colors (RGB), some of them like a beetle's."""


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
    """

    states: NDArray[np.float64]
    colors: tuple[Color, Color, Color] = ((238, 196, 92), (44, 30, 26), (196, 78, 40))


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
            truths.append(Truth(ellipse, _paint(pixels, unhidden, texture, ellipse)))
        dx, dy = np.random.default_rng((self.seed, 2, index)).integers(SHIFTS, size=2)
        pixels += grain[dy : dy + height, dx : dx + width]
        return Frame(index, index * FRAME_INTERVAL, pixels), tuple(truths[::-1])

    @cached_property
    def _scenery(self) -> tuple[NDArray[np.uint8], Floats, NDArray[np.uint8]]:
        """What does not move: the ground with its stems, where stems hide it, and the grain."""
        (width, height), rng = self.size, np.random.default_rng((self.seed, 0))
        ground = _ground(rng, width, height)
        cover = np.zeros((height, width), np.float32)
        for stem in self.stems:
            _add_stem(rng, ground, cover, stem)
        noise = 4 * rng.standard_normal((height + SHIFTS, width + SHIFTS, 1), np.float32)
        noise = noise + 2 * rng.standard_normal((*noise.shape[:2], 3), np.float32)
        # Negative grain wraps to 256 less: added in uint8, it subtracts, and fast.
        grain = np.rint(noise).clip(-GRAIN, GRAIN).astype(np.int8).view(np.uint8)
        return _to_bytes(ground), cover, grain

    @cached_property
    def _textures(self) -> list[Image.Image]:
        rng = np.random.default_rng((self.seed, 1))
        return [_texture(rng, target) for target in self.targets]


def demo(size: tuple[int, int] = (640, 480), frames: int = 300, seed: int = 0) -> Clip:
    """Return the clip to judge a tracker by: one beetle meets every difficulty in 300 frames.

    It passes behind a stem (frames 58 to 69), turns and grows to twice its size, shrinks, jumps
    by more than its length (frame 200), leaves the frame on the right and returns. A longer
    clip begins again, a shorter one ends early.
    """
    scale = _scale(size)
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
    scale = _scale(size)
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
    center, scale = _center(size), _scale(size)
    return Clip(size, (Target(_states(*center, 64 * scale, 36 * scale, theta)),), seed=seed)


def growing(
    size: tuple[int, int] = (640, 480), frames: int = 100, factor: float = 4.0, seed: int = 0
) -> Clip:
    """Return a clip whose target grows until `factor` times as long and wide, and shrinks back."""
    growth = factor ** (0.5 - 0.5 * np.cos(np.arange(frames) * 2 * math.pi / frames))
    growth *= _scale(size)
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
    scale = _scale(size)
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
    scale, (x, y) = _scale(size), _center(size)
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


def _scale(size: tuple[int, int]) -> float:
    """Return how much larger than 640x480 a frame is, in its smaller direction."""
    return min(size[0] / 640, size[1] / 480)


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
    part, x, y = _window(ellipse, 0.6 * small + 1, unhidden.shape)
    if not unhidden[part].size:
        return 0.0
    u, v = _local(x, y, ellipse)
    radius, slope = np.hypot(u, v), np.hypot(u / ellipse.a, v / ellipse.b)
    distance = (radius - 1) * radius / np.maximum(slope, 1e-6)  # to the edge, in pixels
    seen = np.clip(0.5 - distance, 0, 1) * unhidden[part]
    shadow = np.hypot(*_local(x - 0.15 * small, y - 0.3 * small, ellipse))
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
    pixels[part] = _to_bytes(mixed + np.asarray(skin) * seen[:, :, None])
    unhidden[part] -= seen
    return min(float(seen.sum(dtype=np.float64)) / ellipse.area, 1.0)


def _window(
    ellipse: Ellipse, margin: float, shape: tuple[int, ...]
) -> tuple[tuple[slice, slice], Floats, Floats]:
    """Return the part of a picture that holds an ellipse, and its x and y from the center."""
    box, (height, width) = ellipse.box, shape[:2]
    left, top = max(math.floor(box.x - margin), 0), max(math.floor(box.y - margin), 0)
    right = min(math.ceil(box.x + box.width + margin), width)
    bottom = min(math.ceil(box.y + box.height + margin), height)
    x = np.arange(left, right) - ellipse.x
    y = np.arange(top, bottom)[:, None] - ellipse.y
    part = slice(top, max(bottom, 0)), slice(left, max(right, 0))
    return part, x.astype(np.float32), y.astype(np.float32)


def _local(x: Floats, y: Floats, ellipse: Ellipse) -> tuple[Floats, Floats]:
    """Return offsets from an ellipse's center in its own axes, in half-axes."""
    cos, sin = math.cos(ellipse.theta), math.sin(ellipse.theta)
    return (x * cos + y * sin) / ellipse.a, (y * cos - x * sin) / ellipse.b


def _to_bytes(image: Floats) -> NDArray[np.uint8]:
    limited: Floats = np.rint(image).clip(GRAIN, 255 - GRAIN)
    return limited.astype(np.uint8)


def _noise(
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


def _ground(rng: np.random.Generator, width: int, height: int) -> Floats:
    """Return the garden floor: soil and moss, leaves that lie on it, light and depth of field."""
    scale = _scale((width, height))
    soil, moss = np.array([(84, 66, 48), (78, 88, 46)], np.float32)
    blend = np.clip(0.5 + 0.6 * _noise(rng, width, height, 160 * scale), 0, 1)[:, :, None]
    ground: Floats = soil + (moss - soil) * blend
    ground *= 1 + 0.28 * _noise(rng, width, height, 24 * scale)[:, :, None]
    for _ in range(round(420 * width * height / (640 * 480 * scale**2))):
        _add_leaf(rng, ground, scale)

    x = np.linspace(-1, 1, width, dtype=np.float32)
    y = np.linspace(-1, 1, height, dtype=np.float32)[:, None]
    ground *= (1.02 - 0.16 * x - 0.10 * (x**2 + y**2))[:, :, None]
    ground *= (1 + 0.14 * _noise(rng, width, height, 200 * scale))[:, :, None]
    sharp = Image.fromarray(_to_bytes(ground))
    depth = np.abs(y + 0.1 * x - 0.15)
    for radius, start in ((2, 0.25), (6, 0.6)):
        blurred = np.asarray(sharp.filter(ImageFilter.GaussianBlur(radius * scale)), np.float32)
        ground += (blurred - ground) * np.clip((depth - start) / 0.3, 0, 1)[:, :, None]
    return ground


def _add_leaf(rng: np.random.Generator, ground: Floats, scale: float) -> None:
    """Lay a leaf with its veins and its shadow somewhere on the ground."""
    height, width = ground.shape[:2]
    x, y, a = rng.uniform((0, 0, 10 * scale), (width, height, 52 * scale)).tolist()
    leaf = Ellipse(x, y, a, a * rng.uniform(0.2, 0.5), rng.uniform(0, 2 * math.pi))
    color = LEAVES[rng.integers(len(LEAVES))] * np.float32(rng.uniform(0.7, 1.1))
    window, dx, dy = _window(leaf, 8 * scale, ground.shape)
    part = ground[window]

    def inside(shift: float, softness: float) -> tuple[Floats, Floats, Floats]:
        u, v = _local(dx - shift, dy - 1.5 * shift, leaf)
        return u, v, np.clip((1 - u * u - np.abs(v)) * (leaf.b / softness) + 0.5, 0, 1)

    part *= 1 - 0.45 * inside(2.5 * scale, 4 * scale)[2][:, :, None]
    u, v, alpha = inside(0, 1)
    veins = 0.25 * np.exp(-((v / 0.06) ** 2))
    veins += 0.10 * np.sin(16 * (u + 0.7 * np.abs(v))) * np.abs(v)
    shade = 0.92 + 0.22 * v + 0.12 * np.sin(2.5 * u + 1) + veins
    shade += 0.05 * rng.standard_normal(shade.shape, np.float32)
    part += (color * shade[:, :, None] - part) * alpha[:, :, None]


def _add_stem(rng: np.random.Generator, ground: Floats, cover: Floats, stem: Stem) -> None:
    """Put a stem and its shadow on the ground, and mark in `cover` where it hides things."""
    height, width = cover.shape
    y, x = np.ogrid[:height, :width]
    lean = stem.lean * (y - (height - 1) / 2)
    across = ((x - stem.x - lean) / math.hypot(1, stem.lean)).astype(np.float32)
    half = stem.width / 2
    ground *= 1 - 0.5 * np.clip((1.5 - np.abs(across / half - 0.35)) / 0.8, 0, 1)[:, :, None]
    alpha = np.clip(half + 0.5 - np.abs(across), 0, 1)
    roundness = np.sqrt(np.clip(1 - (across / half) ** 2, 0, 1))
    bark = 1 + 0.13 * _noise(rng, width, height, stem.width / 8, stretch=8)
    shade = bark * (0.35 + 0.65 * roundness - 0.25 * across / half)
    color = np.array((112, 104, 72), np.float32) * shade[:, :, None]
    ground += (color - ground) * alpha[:, :, None]
    np.maximum(cover, alpha, out=cover)


def _texture(rng: np.random.Generator, target: Target) -> Image.Image:
    """Return a beetle's skin over -REACH … REACH half-axes, head to the right."""
    side = max(math.ceil(2 * REACH * target.states[:, 2:4].max()), 128)
    u = np.linspace(-REACH, REACH, side, dtype=np.float32)
    v = u[:, None]
    shell, stripe, head = np.array(target.colors, np.float32)

    def step(value: Floats, width: float) -> Floats:
        smooth: Floats = np.clip(value / width + 0.5, 0, 1)[:, :, None]
        return smooth

    wave = np.cos(16 * v * (1 + 0.12 * u * u) + 0.3 * np.sin(5 * u))
    skin = shell + (stripe - shell) * step(wave - 0.1, 0.4)
    front = u - 0.42 + 0.25 * v * v
    skin += (stripe - skin) * step(0.06 - np.abs(front), 0.04)
    skin += (head - skin) * step(front, 0.05)
    skin += (stripe - skin) * step(0.13 - np.hypot(u - 0.72, np.abs(v) - 0.3), 0.05)
    shade = 0.45 + 0.6 * np.sqrt(np.clip(1 - 0.9 * (u * u + v * v), 0, 1))
    shade *= 1 + 0.06 * _noise(rng, side, side, side / 12)
    shine = 90 * np.exp(-((u - 0.05) ** 2) / 0.12 - (v + 0.38) ** 2 / 0.015)
    return Image.fromarray(_to_bytes(skin * shade[:, :, None] + shine[:, :, None]))
