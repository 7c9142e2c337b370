"""What makes a film hard, each as a dial from 0 (easy) to 1 (hard)."""

from __future__ import annotations

import difflib
from dataclasses import dataclass, fields
from typing import Self

from motes.core.errors import ConfigError


@dataclass(frozen=True, slots=True)
class Dials:
    """How hard a film is, in each respect; 0 is easy, and so is every dial that is not set.

    Attributes
    ----------
    motion
        The target moves by up to 0.04 … 0.8 of its side in a frame.
    shake
        The camera jumps at random, with a standard deviation of 0 … 0.35 sides along x and y.
    growth
        The target becomes 1 … 4 times as large in the film, or as small.
    proportions
        Its length over its width changes by a factor of 1 … 4.
    turn
        It turns in the picture, by 0 … 360 degrees in the film.
    roll
        It turns about its upright axis, by 0 … 180 degrees, until its other side is visible.
    light
        The light of the scene changes for good, to a fifth or to 2.5 times.
    shade
        The target comes into a shade, and stays there, with 1 … 0.2 of the light.
    blur
        The lens is out of focus twice, with a standard deviation of up to 0 … 0.12 sides.
    noise
        The picture has noise, with a standard deviation of 2 … 40 gray levels.
    gray
        The film loses 0 … all of its color.
    texture
        The target loses 0 … 95 % of its texture.
    camouflage
        The target takes 0 … all of the mean color and contrast of what is behind it.
    small
        The target's side is 48 … 8 pixels.
    distractors
        None to 4 copies of the target move around it, and pass behind it. At 0 they differ in color
        and size, at 1 they do not.
    occlusion
        Something covers 0 … all of the target for a fourth of the film.
    """

    motion: float = 0.0
    shake: float = 0.0
    growth: float = 0.0
    proportions: float = 0.0
    turn: float = 0.0
    roll: float = 0.0
    light: float = 0.0
    shade: float = 0.0
    blur: float = 0.0
    noise: float = 0.0
    gray: float = 0.0
    texture: float = 0.0
    camouflage: float = 0.0
    small: float = 0.0
    distractors: float = 0.0
    occlusion: float = 0.0

    @classmethod
    def at(cls, name: str, level: float) -> Self:
        """Return dials of which one is at a level; raise a ConfigError if there is none such."""
        if name not in DIALS:
            near = difflib.get_close_matches(name, DIALS, n=1)
            hint = f"did you mean {near[0]}?" if near else f"known are {', '.join(DIALS)}."
            raise ConfigError(f"There is no dial {name!r}; {hint}")
        return cls(**{name: level})

    def __post_init__(self) -> None:
        for name in DIALS:
            if not 0 <= getattr(self, name) <= 1:
                raise ConfigError(f"{name} is {getattr(self, name)}; a dial goes from 0 to 1.")


DIALS = tuple(field.name for field in fields(Dials))
"""The names of the dials."""
