"""Two places that may be the target's, until the evidence decides."""

from __future__ import annotations

import pytest

from motes.core.geometry import Ellipse
from motes.sot.discriminative.standing import APART, DECIDED, Rival

HERE = Ellipse(50.0, 50.0, 10.0, 10.0, 0.0)
THERE = HERE._replace(x=90.0)


def followed(differences: list[float]) -> Rival:
    rival = Rival(HERE)
    for difference in differences:
        rival = rival.after(THERE, difference)
    return rival


def test_a_rival_has_a_place_and_no_lead_at_first() -> None:
    rival = followed([0.0])
    assert rival.alive
    assert rival.place == THERE
    assert (rival.wins, rival.loses) == (False, False)
    assert not Rival(HERE).alive


@pytest.mark.parametrize("sign", [1, -1])
def test_small_differences_add_up(sign: int) -> None:
    assert not followed([sign * 0.4] * 2).wins
    rival = followed([sign * 0.4] * 3)
    assert (rival.wins, rival.loses) == (sign > 0, sign < 0)


@pytest.mark.parametrize("sign", [1, -1])
def test_a_clear_frame_decides_alone(sign: int) -> None:
    rival = followed([sign * 1.01 * DECIDED])
    assert (rival.wins, rival.loses) == (sign > 0, sign < 0)


def test_single_frames_that_contradict_each_other_decide_nothing() -> None:
    rival = followed([0.8, -0.8] * 20)
    assert (rival.wins, rival.loses) == (False, False)


def test_places_part_by_their_distance_in_sides_of_the_target() -> None:
    near = HERE._replace(x=50.0 + 0.99 * APART * HERE.side)
    far = HERE._replace(x=50.0 + 1.01 * APART * HERE.side)
    assert not Rival.parts(near, HERE)
    assert Rival.parts(far, HERE)
