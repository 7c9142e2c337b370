"""The background learns no objects, and forgets its mistakes."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pytest

from motes.core.detection import Detection
from motes.core.frame import Frame
from motes.core.geometry import Box
from motes.mot.detection import ghosts
from motes.mot.detection.background import BackgroundDetector, densest
from motes.mot.detection.selective_update import SelectiveUpdate
from motes.mot.scene import LAG, Scene

SIZE = 14, 30


def frame(index: int, x: int | None, rate: float = 5.0) -> Frame:
    """Return a gray ground with an object at x, if any."""
    rng = np.random.default_rng(index)
    pixels = rng.integers(95, 106, (80, 160, 3)).astype(np.uint8)
    if x is not None:
        pixels[30:60, x : x + SIZE[0]] = (220, 60, 200)
    return Frame(index, index / rate, pixels)


def test_the_picture_to_learn_by_hand() -> None:
    before, now = np.full((3, 9, 9), 10, np.uint8), np.full((3, 9, 9), 50, np.uint8)
    update = SelectiveUpdate(before, 0.0, trial=1.0, patience=3.0)
    mask = np.zeros((9, 9), np.uint8)
    mask[0, 0] = mask[0, 8] = 1
    known = [Box(4.6, -2, 9, 9)]
    for time, left, right in ((0.5, 10, 10), (1.5, 50, 10), (2.5, 50, 10), (3.5, 50, 50)):
        learned = update.learned_from(now, mask, time, known)
        assert (learned[0, 0, 0], learned[0, 0, 8], learned[0, 8, 4]) == (left, right, 50), time


class Listener:
    """A detector that notes what it is told."""

    def __init__(self) -> None:
        self.told: list[Sequence[Box]] = []

    def observe(self, moved: Sequence[Box]) -> None:
        """Note it."""
        self.told.append(moved)

    def __call__(self, frame: Frame) -> list[Detection]:
        """Return a walker."""
        return [Detection(Box(20 + 4 * frame.index, 30, *SIZE))]


def test_a_detector_learns_some_frames_later_where_what_has_moved_is() -> None:
    pictures = [frame(index, 20 + 4 * index) for index in range(12)]
    lists = []
    for ahead in (True, False):
        listener = Listener()
        scene = Scene(listener)
        tracks = [found for _, found in scene.watch(pictures, ahead=ahead)]
        lists.append(listener.told)
    assert lists[0] == lists[1]  # whatever the threads do
    first = next(n for n, boxes in enumerate(listener.told) if boxes)
    (box,) = listener.told[first]
    np.testing.assert_allclose(box, tracks[first][0].box)  # as it goes evenly
    assert first - LAG == 3  # 12 pixels on from its first detection


def test_a_ground_without_noise_is_found_behind_who_passes() -> None:
    """Its pictures are equal to the bit, as in drawn film and where a codec repeats a picture."""
    ground = np.full((6, 40, 3), 120, np.uint8)
    pictures = [ground.copy() for _ in range(30)]
    for index, picture in enumerate(pictures):
        left, right = max(3 * index - 50, 0), max(3 * index - 30, 0)
        picture[:, left:right] = 160, 100, 98  # nearly the ground's brightness
    np.testing.assert_array_equal(densest(pictures), ground)


def test_a_prepared_detector_finds_who_is_in_the_first_frame(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(ghosts, "GHOST", 0.0)
    film = [frame(index, 20 + 3 * index) for index in range(40)]
    for prepared in (True, False):
        detector = BackgroundDetector()
        if prepared:
            detector.prepare(iter(film))
        first = [each.box for each in detector(film[0])]
        later = [each.box for each in [*map(detector, film[1:12])][-1]]
        assert len(first) == prepared
        assert len(later) == 1 + (not prepared)  # and leaves no ghost
