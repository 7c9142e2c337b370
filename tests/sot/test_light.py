"""The light that is taken off each frame: what it follows, and what it does for the tracker."""

from __future__ import annotations

import math

import numpy as np
import pytest
from numpy.typing import NDArray

from motes.core.frame import Frame
from motes.core.geometry import iou
from motes.sot.discriminative import prediction as light_module
from motes.sot.discriminative.prediction import UNNOTICED, Light, overlap, small_picture
from motes.sot.tracker import Tracker
from textured import HEIGHT, WIDTH, seen, textured


@pytest.fixture(scope="module")
def scene() -> NDArray[np.uint8]:
    return textured()


def after(frame: Frame, *frames: Frame, shift: tuple[float, float] = (0, 0)) -> Light:
    """Return the light after frames, of which each is moved by the same shift."""
    light, before = Light(), small_picture(frame)
    for each in frames:
        now = small_picture(each)
        light = light.followed(*overlap(before, now, np.array(shift), each))
        before = now
    return light


@pytest.mark.parametrize("factor", [0.55, 0.8, 1.15])
def test_another_light_is_measured_and_taken_off(scene: NDArray[np.uint8], factor: float) -> None:
    usual, lit = seen(scene, 100, 100), seen(scene, 100, 100, 1, factor)
    light = after(usual, lit)
    assert light.level == pytest.approx(math.log(factor), abs=0.02)
    assert after(usual, lit, lit).level == light.level
    whole = factor * usual.pixels.astype(float) <= 255  # what became white stays so
    restored = light.taken_off(lit)
    assert (restored.index, restored.time) == (lit.index, lit.time)
    off = np.abs(restored.pixels.astype(float) - usual.pixels)[whole]
    assert off.max() <= 4
    assert off.mean() < 2


def test_a_camera_that_moves_is_no_change_of_the_light(scene: NDArray[np.uint8]) -> None:
    # The scene is brighter to the right: without the shift, the pan would seem to be a lamp.
    ramp = np.linspace(0.3, 1, scene.shape[1])[:, None]
    brighter = (scene * ramp).astype(np.uint8)
    usual, moved = seen(brighter, 100, 100), seen(brighter, 200, 130, 1)
    assert abs(after(usual, moved, shift=(-100, -30)).level) < 0.03
    assert after(usual, moved).level > 0.1
    dim = seen(brighter, 200, 130, 1, 0.7)
    level = after(usual, dim, shift=(-100, -30)).level
    assert level == pytest.approx(math.log(0.7), abs=0.03)


def test_frames_in_the_usual_light_are_left(scene: NDArray[np.uint8]) -> None:
    usual = seen(scene, 100, 100)
    assert Light(0.9 * UNNOTICED).taken_off(usual) is usual
    assert Light(-1.1 * UNNOTICED).taken_off(usual) is not usual


@pytest.mark.parametrize("gray", [0, 255])
def test_black_and_white_pictures_say_nothing(scene: NDArray[np.uint8], gray: int) -> None:
    usual = seen(scene, 100, 100)
    flat = Frame(1, 0.04, np.full((HEIGHT, WIDTH, 3), gray, np.uint8))
    assert after(usual, flat).level == 0
    assert after(usual, usual, shift=(WIDTH, 0)).level == 0  # no part is in both


def test_a_cut_changes_the_light_by_a_factor_of_two_at_most(scene: NDArray[np.uint8]) -> None:
    usual, dim = seen(scene, 100, 100), seen(scene, 100, 100, 1, 0.3)
    assert after(usual, dim).level == pytest.approx(-math.log(2))


def test_what_is_learned_fades() -> None:
    assert Light(0.5).learned(0.04).level == 0.5 * 0.96


@pytest.mark.slow
def test_the_tracker_stays_certain_when_the_light_falls(
    scene: NDArray[np.uint8], monkeypatch: pytest.MonkeyPatch
) -> None:
    orange = np.array((147, 47, 17)) + scene[600:640, 600:640] // 3
    target = np.clip(orange, 0, 255).astype(np.uint8)

    def frame(index: int) -> Frame:
        pixels = scene[100 : 100 + HEIGHT, 100 : 100 + WIDTH].copy()
        x = 60 + 3 * index
        pixels[100:140, x : x + 40] = target
        return seen(np.pad(pixels, ((0, 1), (0, 1), (0, 0))), 0, 0, index, 0.96**index)

    def last() -> float:
        tracker = Tracker(seed=0)
        tracker.init(frame(0), (60, 100, 40, 40))
        for index in range(1, 35):
            track = tracker.update(frame(index))
        assert iou(track.ellipse.box, (60 + 3 * index, 100, 40, 40)) > 0.8
        return 1 - track.distance

    with_light = last()
    monkeypatch.setattr(light_module, "UNNOTICED", 10.0)
    assert with_light > last() + 0.05
