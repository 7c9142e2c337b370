"""Objects that were mistaken for each other."""

from __future__ import annotations

import pytest
from msgspec.structs import replace

from motes.core.geometry import Box
from motes.mot.stages.resolve_identity_switches import resolve_identity_switches
from motes.mot.tracked_object import TrackedObject
from scene_objects import BLUE, RED, picture, undetected, visible

LEFT, RIGHT = Box(40, 30, 20, 40), Box(120, 30, 20, 40)
BEFORE = picture(0, (LEFT, RED), (RIGHT, BLUE))
SWITCHED = picture(1, (LEFT, BLUE), (RIGHT, RED))


def pair() -> list[TrackedObject]:
    """Return a red and a blue object; the second has occluded the first."""
    red, blue = visible(1, BEFORE, LEFT), visible(2, BEFORE, RIGHT)
    return [replace(red, occluder_candidate=2), blue]


def test_objects_swap_identities_if_each_looks_like_the_other() -> None:
    before = pair()
    after = resolve_identity_switches(before, SWITCHED)
    assert [each.identity for each in after] == [2, 1]
    assert [each.track for each in after] == [each.track for each in before]
    assert [each.rng for each in after] == [each.rng for each in before[::-1]]
    assert after[0].state.models == before[1].state.models
    assert after[0].occluder_candidate is None


def test_objects_that_look_like_themselves_keep_their_identities() -> None:
    after = resolve_identity_switches(pair(), BEFORE)
    assert [each.identity for each in after] == [1, 2]
    assert after[0].occluder_candidate is None


@pytest.mark.parametrize("why", ["undetected", "overlapping"])
def test_the_decision_waits_until_both_are_detected_and_apart(why: str) -> None:
    one, other = pair()
    if why == "undetected":
        other = undetected(2, BEFORE, RIGHT)
    else:
        other = visible(2, BEFORE, LEFT._replace(x=55))
    assert resolve_identity_switches([one, other], SWITCHED) == [one, other]


def test_an_occluder_that_is_gone_is_forgotten() -> None:
    one, _ = pair()
    (after,) = resolve_identity_switches([one], SWITCHED)
    assert (after.identity, after.occluder_candidate) == (1, None)
