"""Cuts of a film and changes of its light, told from what moves."""

from collections.abc import Callable

import numpy as np
import pytest
from numpy.typing import NDArray

from motes.core.frame import Frame
from motes.video.cuts import PictureChanges, cuts_in

Picture = NDArray[np.uint8]


def scenery(seed: int, low: int, high: int) -> Picture:
    """Return a picture of large patches, with colors in a range."""
    patches = np.random.default_rng(seed).integers(low, high, (6, 8, 3))
    return patches.repeat(20, axis=0).repeat(20, axis=1).astype(np.uint8)


def gray(picture: Picture) -> Picture:
    return np.repeat(picture[..., 1:2], 3, axis=2)


STREET, ROOM = scenery(0, 40, 200), scenery(1, 90, 255)
LAB = scenery(4, 40, 200)  # of much the same grays as the street
GREEN, BLUE = (np.where(each > 120, light, 60) for each, light in (
    (STREET[..., 1:2], (60, 200, 60)), (LAB[..., 1:2], (60, 60, 200))
))  # fmt: skip
CHANGES: dict[str, tuple[Callable[[int], Picture], dict[int, str]]] = {
    "nothing": (lambda i: STREET, {}),
    "cut": (lambda i: ROOM if i >= 5 else STREET, {5: "cut"}),
    "cut in gray": (lambda i: gray(LAB if i >= 5 else STREET), {5: "cut"}),
    "a pan in gray": (lambda i: gray(np.roll(STREET, 2 * i, axis=1)), {}),
    "a shot and back": (lambda i: ROOM if 5 <= i < 9 else STREET, {5: "cut", 9: "cut"}),
    "through black": (lambda i: (STREET, 0 * STREET, ROOM)[min(i // 4, 2)], {8: "cut"}),
    "through what is nearly flat": (
        lambda i: (STREET, (120 + LAB / 25).astype(np.uint8), ROOM)[min(i // 4, 2)],
        {8: "cut"},
    ),
    "from green to blue": (lambda i: (BLUE if i >= 5 else GREEN).astype(np.uint8), {5: "cut"}),
    "of a strip": (lambda i: (ROOM if i >= 5 else STREET)[:2], {5: "cut"}),
    "a black frame": (lambda i: 0 * STREET if i == 6 else STREET, {}),
    "darker": (lambda i: (STREET * (0.6 if i >= 5 else 1)).astype(np.uint8), {5: "light"}),
    "gamma": (
        lambda i: (255 * (STREET / 255) ** (0.6 if i >= 5 else 1)).astype(np.uint8),
        {5: "light"},
    ),
    "slowly darker": (lambda i: (STREET * (1 - 0.004 * i)).astype(np.uint8), {}),
    "a pan": (lambda i: np.roll(STREET, 2 * i, axis=1), {}),
    "noise from the fifth on": (lambda i: STREET if i < 5 else scenery(i, 0, 255), {5: "cut"}),
    "an object": (lambda i: np.where(np.arange(160)[:, None] // 16 == i // 3, ROOM, STREET), {}),
}


@pytest.mark.parametrize("what", CHANGES)
def test_changes(what: str) -> None:
    picture, expected = CHANGES[what]
    changes, frames = PictureChanges(), [Frame(i, i / 25, picture(i)) for i in range(12)]
    found = {frame.index: changes.update(frame) for frame in frames}
    assert {index: change for index, change in found.items() if change} == expected
    cuts = [index for index, change in expected.items() if change == "cut"]
    assert [*cuts_in(frames)] == cuts
