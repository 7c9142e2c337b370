"""Who is who after two objects met: by color, by edges, and not at all where neither tells."""

from __future__ import annotations

import numpy as np
import pytest
from msgspec.structs import replace
from numpy.typing import NDArray

from motes.core.detection import Detection
from motes.core.frame import Frame
from motes.core.geometry import Box
from motes.core.track import Status
from motes.mot.identity_switch import EDGES, is_identity_switch, swap_gain
from motes.mot.scene import Scene
from motes.mot.scene_config import scene_config
from motes.mot.tracked_object import TrackedObject

GROUND = np.random.default_rng(0).integers(90, 110, (80, 200, 3)).astype(np.uint8)
RED, BLUE = (220, 60, 60), (60, 60, 220)
SIDE = 24


def paint(pixels: NDArray[np.uint8], x: int, upright: bool, color: tuple[int, int, int]) -> None:
    """Paint a box with stripes, half of them in a color, half in gray."""
    part = np.full((SIDE, SIDE, 3), 150, np.uint8)
    part[np.arange(SIDE) % 8 < 4] = color
    pixels[28 : 28 + SIDE, x : x + SIDE] = part.swapaxes(0, 1) if upright else part


def picture(index: int, *things: tuple[int, bool, tuple[int, int, int]]) -> Frame:
    pixels = GROUND.copy()
    for thing in things:
        paint(pixels, *thing)
    return Frame(index, index / 25, pixels)


def box(x: int) -> Box:
    return Box(x, 28, SIDE, SIDE)


def known(frame: Frame, x: int, identity: int) -> TrackedObject:
    """Return an object that was seen for a frame, alone."""
    tracker, rng = scene_config().tracker, np.random.default_rng(0)
    one = TrackedObject.begin(identity, tracker, rng, frame, [(frame.time, box(x))] * 2)
    return replace(one, shape_model=EDGES.learn(frame, one.track.ellipse))


@pytest.mark.parametrize(
    ("colors", "stripes", "told"),
    [
        ((RED, BLUE), (True, True), True),  # by color
        ((RED, RED), (True, False), True),  # by edges
        ((RED, RED), (True, True), False),  # neither
        ((RED, BLUE), (True, False), True),
    ],
)
def test_colors_tell_who_is_who_or_edges_do(
    colors: tuple[tuple[int, int, int], ...], stripes: tuple[bool, bool], told: bool
) -> None:
    looks = list(zip(stripes, colors, strict=True))
    before = picture(0, (20, *looks[0]), (120, *looks[1]))
    after = picture(1, (20, *looks[1]), (120, *looks[0]))
    one, other = known(before, 20, 1), known(before, 120, 2)
    assert not is_identity_switch(one, other, before)
    assert is_identity_switch(one, other, after) == told
    if told:
        one, other = one.with_identity_of(other), other.with_identity_of(one)
        assert not is_identity_switch(one, other, after)
        assert (one.identity, other.identity) == (2, 1)


def test_the_gain_of_a_swap_by_hand() -> None:
    assert swap_gain(np.array([[0.5, 0.1], [0.2, 0.7]])) == pytest.approx(0.9)


@pytest.mark.parametrize("alike", [False, True])
def test_two_that_turn_back_behind_each_other_are_told_apart(alike: bool) -> None:
    """They seem to walk past each other, but turn back. Edges tell, if they differ."""
    found: list[Detection] = []
    scene = Scene(lambda _: found)
    for index in range(50):
        step = index if index < 20 else max(40 - index, 2)
        left, right = 10 + 4 * step, 162 - 4 * step
        together = left + SIDE > right
        seen = (right if index < 20 else left,) if together else (left, right)
        found[:] = [Detection(box(x)) for x in seen]
        frame = picture(index, (left, False, RED), (right, not alike, RED))
        said = {each.identity: each.track for each in scene.update(frame)}
        if index == 10:
            (first,) = [i for i, track in said.items() if track.ellipse.x < 100]
    assert len(said) == 2
    assert all(track.status is Status.TRACKING for track in said.values())
    assert (said[first].ellipse.x < 100) == (not alike)
