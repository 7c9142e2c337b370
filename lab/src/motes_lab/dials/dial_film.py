"""Films that are hard in chosen respects, with exact truth."""

from __future__ import annotations

import math
from collections.abc import Iterator
from functools import cached_property
from typing import NamedTuple

import numpy as np
from PIL import Image, ImageFilter

from motes.core.frame import FRAME_INTERVAL, Frame
from motes.core.geometry import Box
from motes.core.types import Singles
from motes.synthetic.scenery import SHIFTS
from motes_lab.dials.appearance import (
    as_bytes,
    flattened,
    hue_rotation,
    matched,
    recolored,
    rolled,
)
from motes_lab.dials.choreography import MARGIN, Choreography
from motes_lab.dials.cutout import Cutout, Pose
from motes_lab.dials.dials import Dials
from motes_lab.dials.scenes import Material, SceneMaterials

SIZE = (400, 300)
"""Width and height of a film."""
FRAMES = 60
SHUTTER = 0.5
"""Share of the time between two frames for which the shutter is open."""
MAX_EXPOSURES = 8
"""Pictures that are averaged into one frame, at most; with less motion, there are fewer."""
GRAIN, NOISE = 2.0, 40.0
"""Standard deviation of the noise, in gray levels, with `noise` 0 and 1."""
SHADE = np.array([0.85, 0.8, 0.7], np.float32)
"""Share of the light of each color that a shade takes, with `shade` 1: shades are bluish."""
LUMA = np.array([0.299, 0.587, 0.114], np.float32)
"""Weights of red, green and blue in gray (Rec. 601)."""


class Shown(NamedTuple):
    """The truth of a frame.

    Attributes
    ----------
    box
        The target's box; also of the part that is hidden or outside of the picture.
    visible
        The visible share of its area.
    """

    box: Box
    visible: float


class _Cast(NamedTuple):
    background: Image.Image
    target: Cutout
    back: Cutout
    occluder: Cutout
    copies: list[Cutout]


class DialFilm:
    """A film of a target, as hard as the dials are set.

    `film[index]` renders a `Frame` and its truth; iterating gives all frames. Equal arguments give
    equal bytes.

    Parameters
    ----------
    scene
        What it shows, see `scene_of`.
    dials
        How hard the film is.
    seed
        Determines the paths and the noise. Films of one scene and seed differ by their dials only.
    size
        Width and height in pixels.
    frames
        Number of frames. Changes that are for good take as long as the film.
    """

    def __init__(
        self,
        scene: SceneMaterials,
        dials: Dials,
        seed: int,
        size: tuple[int, int] = SIZE,
        frames: int = FRAMES,
    ) -> None:
        self._scene, self._dials, self._seed = scene, dials, seed
        self._size, self._frames = size, frames
        self._play = Choreography(dials, np.random.default_rng((seed, 0)), size, frames)

    def __len__(self) -> int:
        return self._frames

    def __iter__(self) -> Iterator[tuple[Frame, Shown]]:
        return (self[index] for index in range(len(self)))

    def __getitem__(self, index: int) -> tuple[Frame, Shown]:
        index = range(len(self))[index]
        pixels = self._exposed(index)
        pixels *= self._light(index)
        if radius := self._play.defocus(index):
            # Pillow blurs bytes; what is over-exposed here stays so.
            sharp = Image.fromarray(as_bytes(pixels))
            pixels = np.array(sharp.filter(ImageFilter.GaussianBlur(radius)), np.float32)
        pixels += self._noise(index)
        gray = (pixels @ LUMA)[:, :, None]
        pixels += self._dials.gray * (gray - pixels)
        return Frame(index, index * FRAME_INTERVAL, as_bytes(pixels)), self._shown(index)

    @cached_property
    def _cast(self) -> _Cast:
        (background, target, back, occluder), dials = self._scene, self._dials
        target = matched(flattened(target, 0.95 * dials.texture), background, dials.camouflage)
        copies = [
            recolored(target, hue_rotation((1 - dials.distractors) * hue * math.pi / 2))
            for hue in self._play.hues.tolist()
        ]
        back = matched(back, target.inside, 0.5)
        return _Cast(Image.fromarray(background), target, back, occluder, copies)

    def _exposed(self, index: int) -> Singles:
        """Return the mean (H, W, 3) of the pictures while the shutter is open."""
        ends = [self._play.target(index + SHUTTER * share) for share in (-0.5, 0.5)]
        way = math.hypot(ends[1].x - ends[0].x, ends[1].y - ends[0].y)
        way += float(np.hypot(*(self._play.jump(index + SHUTTER / 2) - self._play.jump(index))))
        count = min(max(math.ceil(way), 1), MAX_EXPOSURES)
        times = index + SHUTTER * ((np.arange(count) + 0.5) / count - 0.5)
        mean = np.zeros((self._size[1], self._size[0], 3), np.float32)
        for time in times.clip(0).tolist():
            mean += self._picture(time)
        mean /= count
        return mean

    def _picture(self, time: float) -> Singles:
        """Return the scene at a time, without light and noise."""
        cast, play = self._cast, self._play
        x, y = (play.camera(time) + MARGIN).tolist()
        box = (x, y, x + self._size[0], y + self._size[1])
        seen = cast.background.resize(self._size, Image.Resampling.BICUBIC, box)
        picture = np.array(seen, np.float32)
        for copy, pose in zip(cast.copies, play.copies(time), strict=False):
            copy.draw(picture, _factors(copy, pose))
        angle = play.roll(time)
        target = rolled(cast.target, cast.back, angle) if angle else cast.target
        target.draw(picture, _factors(target, play.target(time)))
        if (front := self._occluder(time)) is not None:
            cast.occluder.draw(picture, front)
        return picture

    def _occluder(self, time: float) -> Pose | None:
        cast, play = self._cast, self._play
        box = cast.target.box(_factors(cast.target, play.target(time)))
        pose = play.occluder(time, box)
        return None if pose is None else _factors(cast.occluder, pose)

    def _light(self, index: int) -> Singles:
        """Return the light at each pixel, as an array that fits to (H, W, 3)."""
        play, (width, height) = self._play, self._size
        light = np.full((1, 1, 1), play.light(index), np.float32)
        if not self._dials.shade:
            return light
        target, (y, x) = play.target(index), np.ogrid[:height, :width]
        along = (x - target.x) * math.cos(play.shade_direction)
        along = along + (y - target.y) * math.sin(play.shade_direction)
        passed = play.shade(index) - along / play.side  # in sides, positive where it is shady
        shady = np.clip(passed / 0.3 + 0.5, 0, 1).astype(np.float32)[:, :, None]
        shaded: Singles = light * (1 - self._dials.shade * SHADE * shady)
        return shaded

    @cached_property
    def _grain(self) -> Singles:
        """Noise, larger than a frame; a half of its variance is the same in each color."""
        rng = np.random.default_rng((self._seed, 2))
        deviation = GRAIN + (NOISE - GRAIN) * self._dials.noise
        shape = self._size[1] + SHIFTS, self._size[0] + SHIFTS
        common = rng.standard_normal((*shape, 1), np.float32)
        own = rng.standard_normal((*shape, 3), np.float32)
        grain: Singles = np.float32(deviation * math.sqrt(0.5)) * (common + own)
        return grain

    def _noise(self, index: int) -> Singles:
        """Return the noise (H, W, 3) of a frame, a part of `_grain`."""
        dx, dy = np.random.default_rng((self._seed, 3, index)).integers(SHIFTS, size=2)
        part: Singles = self._grain[dy : dy + self._size[1], dx : dx + self._size[0]]
        return part

    def _shown(self, index: int) -> Shown:
        """Return the truth of a frame."""
        target, front = self._cast.target, self._occluder(index)
        pose = _factors(target, self._play.target(index))
        box = target.box(pose)
        right, bottom = box.x + box.width, box.y + box.height
        if (
            front is None
            and min(box[:2]) >= 0
            and right <= self._size[0]
            and bottom <= self._size[1]
        ):
            return Shown(box, 1.0)
        whole = np.zeros((self._size[1], self._size[0], 3), np.float32)
        part, matte = target.draw(whole, pose)
        area = float(target.matte.sum()) * pose.width * pose.height
        if front is not None:
            hidden = np.zeros_like(whole)
            over, cover = self._cast.occluder.draw(hidden, front)
            hidden[over] = cover[:, :, None]
            matte = matte * (1 - hidden[part][:, :, 0])
        return Shown(box, min(float(matte.sum(dtype=np.float64)) / area, 1.0))


def scene_of(material: Material, seed: int, size: tuple[int, int] = SIZE) -> SceneMaterials:
    """Return a scene for films of a width and height."""
    large = size[0] + 2 * MARGIN, size[1] + 2 * MARGIN
    return material.scene(np.random.default_rng((seed, 1)), large)


def _factors(cutout: Cutout, pose: Pose) -> Pose:
    """Return a pose in factors of a cutout's size, from one in sides of its box."""
    return pose._replace(width=pose.width / cutout.side, height=pose.height / cutout.side)
