"""Clips that are hard in one respect at a time, in memory and as folders of sequences."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np
from PIL import Image

from motes.core.errors import FormatError
from motes.core.frame import Frame
from motes.core.types import Floats
from motes_lab.dials.dial_film import FRAMES, SIZE, DialFilm, scene_of
from motes_lab.dials.dials import DIALS, Dials
from motes_lab.dials.scenes import Garden, Material

EASY = "easy"
"""The name of the clips with all dials at 0."""
LEAST_VISIBLE = 0.1
"""With a smaller visible share of its area, a target counts as absent."""
QUALITY = 92
"""Quality of the pictures (JPEG) in a folder."""


class DialClip(NamedTuple):
    """A clip with its truth.

    Attributes
    ----------
    name
        The dial, its level and the seed, such as `motion-0.50-3`; `easy-3` with all dials at 0.
    frames
        Its frames.
    boxes
        (frames, 4): x, y, width, height of the target; NaN where less than a tenth is visible.
    """

    name: str
    frames: list[Frame]
    boxes: Floats


def clip_name(dial: str, level: float, seed: int) -> str:
    """Return the name of a clip."""
    return f"{dial}-{level:.2f}-{seed}" if level else f"{EASY}-{seed}"


def setting_of(name: str) -> tuple[str, float, int] | None:
    """Return the dial, the level and the seed of a clip; None for another name."""
    match = re.fullmatch(r"(?:([a-z]+)-(\d\.\d\d)|easy)-(\d+)", name)
    if match is None:
        return None
    dial, level, seed = match.groups()
    return dial or EASY, float(level or 0), int(seed)


def dial_clips(
    dials: Iterable[str] = DIALS,
    levels: Sequence[float] = (0.0, 0.5, 1.0),
    seeds: Iterable[int] = range(3),
    material: Material | None = None,
    *,
    size: tuple[int, int] = SIZE,
    frames: int = FRAMES,
) -> Iterator[DialClip]:
    """Yield a clip for each dial, level and seed; at level 0, all dials have one in common.

    Parameters
    ----------
    dials
        Names of dials, see `Dials`.
    levels
        From 0 to 1.
    seeds
        Each gives another scene, with other paths.
    material
        What the scenes are made of: rendered ones by default, or `film_cutouts.cut_out(films)`.
    size, frames
        Width and height in pixels, and the length of each clip.

    Raises
    ------
    ConfigError
        If there is no such dial, or a level is not from 0 to 1.
    """
    for seed in seeds:
        scene = scene_of(material or Garden(), seed, size)
        done: set[str] = set()
        for dial in dials:
            for level in levels:
                if (name := clip_name(dial, level, seed)) not in done:
                    done.add(name)
                    film = DialFilm(scene, Dials.at(dial, level), seed, size, frames)
                    yield clip_of(name, film)


def clip_of(name: str, film: DialFilm) -> DialClip:
    """Return the clip of a film."""
    shown, truths = zip(*film, strict=True)
    boxes = np.array([truth.box for truth in truths])
    boxes[[truth.visible < LEAST_VISIBLE for truth in truths]] = np.nan
    return DialClip(name, list(shown), boxes)


def write_clip(clip: DialClip, folder: Path) -> None:
    """Write a clip as a sequence of OTB's layout, which `load_dataset` reads.

    Raises
    ------
    FormatError
        If a file cannot be written.
    """
    try:
        (folder / clip.name / "img").mkdir(parents=True, exist_ok=True)
        for frame in clip.frames:
            path = folder / clip.name / "img" / f"{frame.index + 1:08d}.jpg"
            Image.fromarray(frame.pixels).save(path, quality=QUALITY)
        boxes = clip.boxes + np.array([1, 1, 0, 0])  # OTB counts pixels from 1
        lines = [",".join(f"{value:.3f}" for value in box) for box in boxes.tolist()]
        text = "\n".join(lines) + "\n"
        (folder / clip.name / "groundtruth_rect.txt").write_text(text, encoding="utf-8")
    except OSError as error:
        raise FormatError(
            f"{error.filename} cannot be written: {error.strerror}; make room, or choose another "
            f"folder."
        ) from None
