"""The angle of an ellipse, which is the same after half a turn: it goes on from frame to frame."""

import math
from pathlib import Path

import numpy as np
import pytest

from clips import write_pictures
from motes import Frame, Tracker, correct
from oracles import radii

FIRST = (60, 60, 30, 12, 1.4)
STEP = 0.05
"""Radians in a frame: the target passes half a right angle to each side of upright."""


def picture(index: int) -> np.ndarray:
    """Return a red ellipse, three times as long as wide, that turns over noise."""
    pixels = np.random.default_rng(index).integers(90, 110, (120, 120, 3)).astype(np.uint8)
    inside = radii((120, 120), (60, 60, 30, 10, FIRST[4] + STEP * index))[1] < 1
    pixels[inside] = (220, 40, 40)
    return pixels


def turned(angles: list[float]) -> float:
    """Return how far angles turn in all; raise an AssertionError for a jump."""
    steps = np.diff(angles)
    assert abs(steps).max() < 0.5
    return angles[-1] - angles[0]


@pytest.mark.parametrize("start", [0, 1, -2])
def test_a_tracked_angle_does_not_jump_by_half_a_turn(tmp_path: Path, start: int) -> None:
    first = FIRST[4] + start * math.pi
    tracker = Tracker("maggio", 1)
    angles = [tracker.init(Frame(0, 0.0, picture(0)), (*FIRST[:4], first)).ellipse.theta]
    assert angles == [pytest.approx(first)]
    for index in range(1, 20):
        angles.append(tracker.update(Frame(index, index / 25, picture(index))).ellipse.theta)
        assert tracker.info.track.ellipse.theta == angles[-1]
    assert turned(angles) == pytest.approx(19 * STEP, abs=0.25)  # past upright, at frame 4
    tracker.save(tmp_path / "tracker")
    following = Frame(20, 20 / 25, picture(20))
    again = Tracker.load(tmp_path / "tracker").update(following)
    assert again.ellipse == tracker.update(following).ellipse
    theta = FIRST[4] + 20 * STEP + 3 * math.pi  # what a user says is not turned back
    assert tracker.correct((*FIRST[:4], theta)).ellipse.theta == pytest.approx(theta)


@pytest.mark.slow
def test_corrected_angles_go_on_from_the_keyframe(tmp_path: Path) -> None:
    write_pictures(tmp_path / "film.mkv", map(picture, range(16)))
    marks = {index: (*FIRST[:4], FIRST[4] + STEP * index) for index in (0, 15)}
    for keys in (marks, {0: marks[0]}, {15: marks[15]}):
        tracks = correct(tmp_path / "film.mkv", keys, "maggio")
        angles = [track.ellipse.theta for track in tracks]
        assert turned(angles) == pytest.approx(15 * STEP, abs=0.3)
        for index, mark in keys.items():
            assert angles[index] == pytest.approx(mark[4], abs=1e-6)
