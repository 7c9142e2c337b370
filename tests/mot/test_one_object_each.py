"""One object for each vehicle and each person, from pictures to counts: entering and abreast."""

from __future__ import annotations

from collections.abc import Callable, Iterator

import cv2
import numpy as np
import pytest
from numpy.typing import NDArray

from motes.core.frame import Frame
from motes.core.track import Status
from motes.mot.analytics.events import EventCounter
from motes.mot.analytics.regions import Line, Regions
from motes.mot.detection.background import BackgroundDetector
from motes.mot.scene import Scene

WIDTH, HEIGHT, FRAMES = 320, 180, 90
Draw = Callable[[NDArray[np.uint8], float], None]
"""Draws what moves into a picture, as far along its way as a number of pixels."""


def film(draw: Draw) -> Iterator[Frame]:
    """Yield a still ground before which something goes from the left to the right."""
    rng = np.random.default_rng(0)
    coarse = rng.integers(95, 125, (45, 80, 3)).astype(np.uint8)
    ground = np.asarray(cv2.resize(coarse, (WIDTH, HEIGHT)), np.uint8)
    for n in range(FRAMES):
        picture = ground.copy()
        draw(picture, 5.0 * n - 60)
        noisy = picture + rng.normal(0, 2, picture.shape)
        yield Frame(n, n / 25, noisy.clip(0, 255).astype(np.uint8))


def walker(picture: NDArray[np.uint8], x: float, foot: int, shirt: tuple[int, int, int]) -> None:
    """Draw a person of 80 pixels: legs, a trunk, a head."""
    left = round(x)
    for leg in (-7, 1):
        cv2.rectangle(picture, (left + leg, foot - 38), (left + leg + 6, foot), (40, 40, 60), -1)
    cv2.rectangle(picture, (left - 12, foot - 64), (left + 12, foot - 34), shirt, -1)
    cv2.ellipse(picture, (left, foot - 72), (6, 9), 0, 0, 360, (220, 180, 150), -1)


def abreast(apart: float) -> Draw:
    """Return what draws two people who walk together."""

    def draw(picture: NDArray[np.uint8], way: float) -> None:
        walker(picture, way, 140, (200, 60, 50))
        walker(picture, way + apart, 146, (50, 70, 190))

    return draw


def car(picture: NDArray[np.uint8], way: float) -> None:
    """Draw a car whose windows show the ground, under a thin roof."""
    left, behind = round(way), picture.copy()
    cv2.rectangle(picture, (left, 110), (left + 110, 140), (180, 40, 40), -1)
    cv2.rectangle(picture, (left + 25, 88), (left + 85, 110), (180, 40, 40), -1)
    inside = slice(90, 106), slice(max(left + 30, 0), max(left + 80, 0))
    picture[inside] = behind[inside]


@pytest.mark.slow
@pytest.mark.parametrize(("draw", "many"), [(car, 1), (abreast(22), 2), (abreast(45), 2)])
def test_each_is_counted_once(draw: Draw, many: int) -> None:
    frames, detector = [*film(draw)], BackgroundDetector()
    detector.prepare(frames)
    scene, counter = Scene(detector, seed=0), EventCounter(Regions((Line((160, 0, 160, 180)),)))
    events, seen = [], []
    for _, tracks in scene.watch(frames):
        events += counter.update(tracks)
        seen.append(sum(each.status is Status.TRACKING for each in tracks))
    events += counter.finish()
    assert [each.event for each in events].count("crosses") == many
    assert np.median([n for n in seen if n]) == many
