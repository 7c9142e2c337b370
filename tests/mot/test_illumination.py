"""What light and a trembling camera change is no foreground; what has edges of its own is."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from motes.kernels.structures import LightLimits
from motes.mot.detection.illumination import (
    Background,
    with_enclosed,
    without_light,
    without_tremble,
)
from motes.mot.detection.planes import planes_of

Picture = NDArray[np.uint8]
PATCH = slice(20, 60), slice(30, 70)


def wall() -> Picture:
    """Return a wall of colored bricks with a bright lintel."""
    pixels = np.full((80, 100, 3), (150, 110, 90), np.uint8)
    pixels[::10] = (180, 170, 160)
    pixels[:, ::20] = (180, 170, 160)
    return pixels


def kept(pixels: Picture, shadow: float = 0.5, highlight: float = 1.25) -> float:
    """Return the share of the patch that counts as an object."""
    mask = np.zeros((80, 100), np.uint8)
    mask[PATCH] = 1
    limits = LightLimits(shadow, highlight, tint=12, texture=6)
    left = without_light(mask, planes_of(pixels), Background(planes_of(wall()), 4.0), limits)
    return float(left[PATCH].mean())


def scaled(factor: float) -> Picture:
    pixels = wall()
    pixels[PATCH] = np.rint(factor * pixels[PATCH])
    return pixels


@pytest.mark.parametrize("factor", [0.6, 0.8, 1.15])
def test_light_that_leaves_the_edges_is_no_object(factor: float) -> None:
    assert kept(scaled(factor)) < 0.2
    assert kept(scaled(factor), 1, 1) == 1  # none is removed


@pytest.mark.parametrize("factor", [0.3, 1.6])
def test_more_than_light_is_an_object(factor: float) -> None:
    assert kept(scaled(factor)) > 0.9


def test_an_object_of_the_walls_mean_color_has_other_edges() -> None:
    """A coat as bright as the wall in the shade, with folds in place of bricks."""
    pixels = wall()
    pixels[PATCH] = (105, 77, 63)
    pixels[20:60, 30:70:4] = (135, 99, 81)
    assert kept(pixels) > 0.5


def test_a_tremble_of_a_pixel_is_no_foreground() -> None:
    background = Background(planes_of(wall()), 4.0)
    everywhere = np.ones((80, 100), np.uint8)
    shaken = np.roll(wall(), (1, 1), axis=(0, 1))
    assert without_tremble(everywhere, planes_of(shaken), background).sum() == 0
    shaken[30:40, 40:50] = 20
    assert without_tremble(everywhere, planes_of(shaken), background).sum() == 100


def test_what_an_outline_encloses_is_no_shadow() -> None:
    mask, before = np.zeros((2, 40, 40), np.uint8)
    before[10:30, 10:25] = before[25:30, 25:38] = 1  # an object with a shadow beside it
    mask[10:30, 10:25] = 1
    mask[12:28, 12:23] = 0
    mask[18:20, 10:12] = 0  # a gap in its outline
    filled = with_enclosed(mask, before)
    assert filled[12:28, 12:23].all()
    assert not filled[:, 25:].any()
    open_side = mask.copy()
    open_side[12:28, 23:25] = 0
    assert not with_enclosed(open_side, before)[14:26, 14:21].any()
