"""What has left its place, which the background still has."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from motes.core.frame import Frame
from motes.core.geometry import Box, iou
from motes.mot.detection import ghosts
from motes.mot.detection.background import BackgroundDetector
from motes.mot.detection.ghosts import without_ghosts

THING, GONE = Box(20, 30, 16, 30), Box(100, 30, 16, 30)


def painted(ground: NDArray[np.uint8], box: Box) -> NDArray[np.uint8]:
    """Return a picture with a bright box on it."""
    out = ground.copy()
    x, y, width, height = map(int, box)
    out[y : y + height, x : x + width] = (220, 200, 60)
    return out


def ground(seed: int = 0) -> NDArray[np.uint8]:
    return np.random.default_rng(seed).integers(95, 106, (120, 160, 3)).astype(np.uint8)


def green(pixels: NDArray[np.uint8]) -> NDArray[np.uint8]:
    return np.ascontiguousarray(pixels[:, :, 1])


def test_a_patch_that_fills_the_picture_has_no_outline_and_stays() -> None:
    all_of_it = Box(0, 0, 160, 120)
    mask = np.ones((120, 160), np.uint8)
    assert without_ghosts([all_of_it], mask, green(ground()), green(ground(1))) == [all_of_it]


def test_who_walks_off_leaves_no_ghost(monkeypatch: pytest.MonkeyPatch) -> None:
    """Somebody is in the first frame, which makes the background, and leaves from frame 3 on."""
    for share, left in ((0.5, 0), (0.0, 1)):
        monkeypatch.setattr(ghosts, "GHOST", share)
        detector = BackgroundDetector()
        for index in range(7):
            place = GONE._replace(x=100.0 - 8 * max(0, index - 3))
            found = detector(Frame(index, index / 25, painted(ground(index), place)))
        boxes = [each.box for each in found]
        assert sum(iou(box, place) > 0.8 for box in boxes) == 1
        assert sum(abs(box.x - GONE.x) <= 2 for box in boxes) == left
