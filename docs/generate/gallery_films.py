"""The twenty kinds of film of docs/gallery.md, all rendered."""

from __future__ import annotations

import io
import math
from collections.abc import Callable, Iterable
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray
from PIL import Image

from motes import Frame, synthetic
from motes.core.geometry import Ellipse
from motes.core.types import Bytes, Floats
from motes.synthetic.beetle import Target
from motes.synthetic.clips import Clip, Truth

Shots = Iterable[tuple[Frame, Truth]]

SIZE = (320, 240)
FRAMES = 60
"""Frames of a walk."""
MOMENTS = 8
"""Pictures that are averaged where motion is blurred."""
AWAY = Truth(Ellipse(-1000, -1000, 10, 10, 0), 0.0)
"""The truth of a target that is not in the picture."""


class Kind(NamedTuple):
    """A kind of film.

    Attributes
    ----------
    title, words
        What it is called, and what happens in it.
    film
        Renders it; its target is in the first frame.
    moments
        The frames that are shown.
    """

    title: str
    words: str
    film: Callable[[], Shots]
    moments: tuple[int, int, int]

    @property
    def name(self) -> str:
        """The name of its picture."""
        return self.title.lower().replace(" ", "-")


def first(film: Iterable[tuple[Frame, tuple[Truth, ...]]], start: int = 0) -> Shots:
    """Yield a film of several objects, of which the first is the target, from a frame onward."""
    for frame, truths in film:
        if frame.index >= start:
            index = frame.index - start
            yield Frame(index, frame.time, frame.pixels), truths[0]


def path(time: NDArray[Any], phase: float, half: tuple[float, float] = (24, 18)) -> Floats:
    """Return the states at some times of a target that wanders about, with these half-axes."""
    x, y = 160 + 80 * np.sin(time / 14 + phase), 120 + 55 * np.sin(time / 21 + 2 * phase)
    return np.stack(np.broadcast_arrays(x, y, *half, 0.2 * np.sin(time / 9)), axis=1)


def walk(seed: int, half: tuple[float, float] = (24, 18)) -> Shots:
    """Yield a film of a target that wanders about, with these half-axes."""
    return first(Clip(SIZE, (Target(path(np.arange(FRAMES), seed, half)),), seed=seed))


def shaken(seed: int) -> Shots:
    """Yield a walk before a camera that jumps by a third of the target's side."""
    states = path(np.arange(FRAMES), seed) + np.array([80, 60, 0, 0, 0])
    jumps = np.random.default_rng(seed).normal(0, 14, (FRAMES, 2)).clip(-40, 40).round()
    for frame, truth in first(Clip((480, 360), (Target(states),), seed=seed)):
        left, top = (jumps[frame.index] + (80, 60)).astype(int).tolist()
        pixels = frame.pixels[top : top + SIZE[1], left : left + SIZE[0]]
        x, y, *rest = truth.ellipse
        ellipse = Ellipse(x - left, y - top, *rest)
        yield Frame(frame.index, frame.time, np.ascontiguousarray(pixels)), Truth(ellipse, 1.0)


def blurred(seed: int) -> Shots:
    """Yield a fast walk, each frame the mean of the moments in which the shutter is open."""
    time = 5 * (np.arange(FRAMES)[:, None] + np.arange(MOMENTS) / (2 * MOMENTS))
    clip = Clip(SIZE, (Target(path(time.ravel(), seed)),), seed=seed)
    for index in range(FRAMES):
        shown = [clip[MOMENTS * index + moment] for moment in range(MOMENTS)]
        mean = np.mean([frame.pixels for frame, _ in shown], axis=0)
        yield Frame(index, index / 25, mean.astype(np.uint8)), shown[MOMENTS // 2][1][0]


def changed(film: Shots, change: Callable[[Bytes, int], Bytes]) -> Shots:
    """Yield a film whose pictures are changed, given the number of each."""
    for frame, truth in film:
        yield Frame(frame.index, frame.time, change(frame.pixels, frame.index)), truth


def dark(pixels: Bytes, index: int) -> Bytes:
    """Return a picture with a fifth of the light, and the noise of a camera at night."""
    noise = np.random.default_rng((7, index)).normal(0, 8, pixels.shape)
    return np.clip(0.2 * pixels + noise, 0, 255).astype(np.uint8)


def snowy(pixels: Bytes, index: int) -> Bytes:
    """Return a picture with noise of 40 gray levels."""
    noise = np.random.default_rng((7, index)).normal(0, 40, pixels.shape)
    return np.clip(pixels + noise, 0, 255).astype(np.uint8)


def brighter(pixels: Bytes, index: int) -> Bytes:
    """Return a picture whose light grows to 2.5 times in 20 frames."""
    light = 1 + 1.5 * min(max((index - 15) / 20, 0), 1)
    lit: Bytes = np.clip(light * pixels, 0, 255).astype(np.uint8)
    return lit


def shady(pixels: Bytes, _: int) -> Bytes:
    """Return a picture whose left half has a fifth of the light."""
    light = np.interp(np.arange(pixels.shape[1]), (140, 160), (0.2, 1))
    shaded: Bytes = (pixels * light[:, None]).astype(np.uint8)
    return shaded


def without_color(pixels: Bytes, _: int) -> Bytes:
    """Return a gray picture."""
    return np.array(Image.fromarray(pixels).convert("L").convert("RGB"))


def compressed(pixels: Bytes, _: int) -> Bytes:
    """Return a picture as it is after strong compression."""
    file = io.BytesIO()
    Image.fromarray(pixels).save(file, "JPEG", quality=4)
    return np.array(Image.open(file))


def far() -> Shots:
    """Yield the street from three times as far away."""
    for frame, truth in first(synthetic.Street()):
        x, y, a, b, theta = truth.ellipse
        pixels = np.array(Image.fromarray(frame.pixels).reduce(3))
        ellipse = Ellipse((x - 1) / 3, (y - 1) / 3, a / 3, b / 3, theta)
        yield Frame(frame.index, frame.time, pixels), Truth(ellipse, truth.visible)


def transparent() -> Shots:
    """Yield a walk of a target through which half of the ground is seen."""
    time = np.arange(100)
    x, y = 160 + 90 * np.sin(time / 16), 120 + 60 * np.sin(time / 23)
    states = np.stack(np.broadcast_arrays(x, y, 34.0, 24.0, 0.2 * np.sin(time / 9)), axis=1)
    empty = Clip(SIZE, (Target(states - np.array([1000, 0, 0, 0, 0])),))
    for (frame, (truth,)), (ground, _) in zip(Clip(SIZE, (Target(states),)), empty, strict=True):
        mixed = (frame.pixels.astype(np.uint16) + ground.pixels) // 2
        yield Frame(frame.index, frame.time, mixed.astype(np.uint8)), truth


def twins() -> Shots:
    """Yield two targets of the same colors, which meet and turn back; that behind is followed."""
    there = [target.states[:60] for target in synthetic.crossing(SIZE).targets]
    there_and_back = [Target(np.concatenate([states, states[::-1]])) for states in there]
    return first(Clip(SIZE, tuple(there_and_back)))


def zoomed() -> Shots:
    """Yield a walk that a camera follows, and zooms in to three times and out again."""
    wide = synthetic.demo((640, 480), frames=57)
    for frame, (truth,) in wide:
        zoom = 3 ** math.sin(math.pi * frame.index / 56)
        width, height = 640 / zoom, 480 / zoom
        x, y, a, b, theta = truth.ellipse
        left = float(np.clip(x - width / 2, 0, 640 - width))
        top = float(np.clip(y - height / 2, 0, 480 - height))
        part = left, top, left + width, top + height
        seen = Image.fromarray(frame.pixels).resize(SIZE, Image.Resampling.BILINEAR, part)
        scale = SIZE[0] / width
        place = (x + 0.5 - left) * scale - 0.5, (y + 0.5 - top) * scale - 0.5
        ellipse = Ellipse(*place, a * scale, b * scale, theta)
        yield Frame(frame.index, frame.time, np.array(seen)), Truth(ellipse, truth.visible)


def cut() -> Shots:
    """Yield a film that is cut to another place, and back to the target, which has moved on."""
    blue = Target(path(np.arange(FRAMES), 5), colors=((30, 60, 160), (210, 220, 230), (20, 20, 40)))
    other = first(Clip(SIZE, (blue,), seed=5))
    for (frame, truth), (elsewhere, _) in zip(walk(4), other, strict=True):
        shown = 20 <= frame.index < 40
        yield (elsewhere, AWAY) if shown else (frame, truth)


KINDS = (
    Kind("Night", "a fifth of the light, and noise", lambda: changed(walk(0), dark), (5, 30, 55)),
    Kind("Snow", "noise of 40 gray levels", lambda: changed(walk(1), snowy), (5, 30, 55)),
    Kind("Small", "8 pixels wide", lambda: walk(2, (4, 3)), (5, 30, 55)),
    Kind("Far", "a car of 29 by 10 pixels", far, (20, 90, 130)),
    Kind(
        "Fast",
        "leaps of more than its width",
        lambda: first(synthetic.jumping(SIZE, frames=80)),
        (12, 20, 24),
    ),
    Kind("Alike", "it meets its twin, and both turn back", twins, (10, 58, 110)),
    Kind("Hidden", "a car behind a lorry", lambda: first(synthetic.Street()), (40, 90, 130)),
    Kind("Shrinking", "to a quarter", lambda: first(synthetic.growing(SIZE), 50), (5, 25, 48)),
    Kind("Turning", "once around itself", lambda: first(synthetic.turning(SIZE)), (10, 40, 70)),
    Kind("Shaking camera", "by a third of its side", lambda: shaken(3), (5, 30, 55)),
    Kind("Zoom", "in to three times, and out", zoomed, (4, 28, 52)),
    Kind("Light change", "to 2.5 times", lambda: changed(walk(8), brighter), (5, 30, 55)),
    Kind("Shadow", "a fifth of the light", lambda: changed(walk(7), shady), (5, 30, 55)),
    Kind("Crowd", "a player among his team", lambda: first(synthetic.Pitch()), (10, 80, 150)),
    Kind("Transparent", "half of the ground shines through", transparent, (10, 50, 90)),
    Kind("Motion blur", "0.7 of its side a frame", lambda: blurred(9), (5, 30, 55)),
    Kind(
        "Compressed",
        "quality 4 of JPEG",
        lambda: changed(first(synthetic.Pitch()), compressed),
        (10, 80, 150),
    ),
    Kind(
        "Gray",
        "a player without colors",
        lambda: changed(first(synthetic.Pitch()), without_color),
        (10, 80, 150),
    ),
    Kind("Cut", "to another place and back", cut, (15, 30, 50)),
    Kind(
        "Leaving",
        "out of the picture, and back",
        lambda: first(synthetic.demo(SIZE), 204),
        (8, 35, 90),
    ),
)
