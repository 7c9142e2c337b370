"""Who is who in a group that is seen apart again: by colors, by edges, and also who is hidden."""

from collections.abc import Sequence

import numpy as np
import pytest
from msgspec.structs import replace

from motes import Box, Detection, Ellipse, Frame, Scene, Status
from motes.core.types import Floats
from motes.mot.look import UNKNOWN, Look, costs, telling
from motes.mot.stages.tell_apart import tell_apart
from motes.mot.tracked_object import TrackedObject
from scene_objects import BLUE, RED, SIZE, Color, config, occluded, picture, visible, with_look

GREEN, GRAY = (60, 220, 60), (100, 100, 100)
PLACES = [Box(20, 30, 20, 40), Box(90, 30, 20, 40), Box(160, 30, 20, 40)]
TOUCH = 0.1


def met(
    before: Sequence[Color], hidden: Sequence[int] = (), others: Sequence[int] = (1, 2, 3)
) -> list[TrackedObject]:
    """Return objects 1, 2, ... of these colors, side by side, that have met each other."""
    seen = picture(0, *zip(PLACES, before, strict=False))
    found = list[TrackedObject]()
    for identity, (place, _) in enumerate(zip(PLACES, before, strict=False), start=1):
        one = visible(identity, seen, place)
        (look,) = Look.at(seen, [one.track.ellipse])
        if identity in hidden:
            one = occluded(identity, seen, place)
        found.append(replace(one, known=look, met=frozenset(others) - {identity}))
    return found


def after(
    objects: Sequence[TrackedObject], *colors: Color, free: Sequence[Detection] = ()
) -> list[int]:
    """Return the identities where these colors are seen now."""
    now = picture(1, *zip(PLACES, colors, strict=False))
    return [each.identity for each in tell_apart(objects, free, now, 1, TOUCH)]


def test_a_group_is_assigned_as_a_whole() -> None:
    three = met((RED, GREEN, BLUE))
    assert after(three, RED, GREEN, BLUE) == [1, 2, 3]
    assert after(three, GREEN, RED, BLUE) == [2, 1, 3]
    assert after(three, GREEN, BLUE, RED) == [2, 3, 1]  # three in a circle
    assert after(met((RED, RED, RED)), RED, RED, RED) == [1, 2, 3]


def test_who_is_hidden_may_be_the_one_that_is_seen() -> None:
    """The one detection of two that met went on as the other one."""
    two = met((RED, BLUE), hidden=[1], others=[1, 2])
    assert after(two, RED, RED) == [2, 1]
    assert after(two, RED, BLUE) == [1, 2]
    # Three: the last one is seen as the first; the hidden first one has what is left.
    assert after(met((RED, GREEN, BLUE), hidden=[1]), BLUE, GREEN, RED) == [3, 2, 1]
    # Nor need it be known how the hidden one looks.
    two[0] = replace(two[0], known=None)
    assert after(two, RED, RED) == [2, 1]
    assert after(two, RED, BLUE) == [1, 2]


def test_an_unknown_look_costs_as_much_as_one_between_one_person_and_two() -> None:
    """At the mean distances of one person before and after an occlusion, and of two people."""

    def away(distance: float) -> Floats:
        """Return a histogram so far from the first one."""
        share = (1 - distance**2) ** 2
        return np.array([share, 1 - share])

    known = Look(away(0), away(0))
    seen = Look(away(0.49), away(0.31)), Look(away(0.81), away(0.36))
    (one, unknown), (two, other) = costs(seen, [known, None])
    assert unknown == other == pytest.approx((one + two) / 2, abs=0.5)


@pytest.mark.parametrize(("distance", "tells"), [(0.3, 0.0), (0.5, 0.5), (0.7, 1.0)])
def test_looks_tell_the_less_the_more_alike_all_are(distance: float, tells: float) -> None:
    share = (1 - distance**2) ** 2
    one, other = (Look(np.array(color), np.ones(1)) for color in ((1, 0), (share, 1 - share)))
    assert telling([one, other]) == pytest.approx(tells)
    assert telling([one]) == telling([]) == 1  # what is not known of others says nothing
    mirrored = costs([one, other], [one, other, None], tells)
    assert mirrored[:, 2].tolist() == [UNKNOWN, UNKNOWN]
    full = costs([one, other], [one, other])
    assert mirrored[:, :2] == pytest.approx(UNKNOWN + tells * (full - UNKNOWN))


@pytest.mark.parametrize(("color", "identity"), [(RED, 3), (BLUE, 1)])
def test_who_is_not_known_takes_no_identity_among_those_that_all_look_alike(
    color: Color, identity: int
) -> None:
    """It looks like the hidden first one, and so does the second one, or not."""
    first, second, new = met((RED, color, RED), hidden=[1])
    settled = [with_look(first, RED), with_look(second, color), replace(new, known=None)]
    assert after(settled, GRAY, color, RED)[2] == identity


@pytest.mark.parametrize("why", ["never met", "detection of somebody unknown", "at the border"])
def test_nobody_is_exchanged_who(why: str) -> None:
    two = met((RED, BLUE), others=[] if why == "never met" else [1, 2])
    free = [Detection(place) for place in PLACES[:2] if why.startswith("detection")]
    if why == "at the border":
        two = [
            replace(each, track=replace(each.track, ellipse=each.track.ellipse._replace(y=5)))
            for each in two
        ]
    assert after(two, BLUE, RED, free=free) == [1, 2]


def test_an_exchange_takes_the_models_along_and_leaves_the_places() -> None:
    before = met((RED, BLUE), others=[1, 2])
    now = tell_apart(before, (), picture(1, *zip(PLACES, (BLUE, RED), strict=False)), 1, TOUCH)
    assert [each.identity for each in now] == [2, 1]
    assert [each.track for each in now] == [each.track for each in before]
    assert [each.rng for each in now] == [each.rng for each in before[::-1]]
    assert now[0].state.models == before[1].state.models


def test_what_is_decided_may_be_decided_again_until_all_have_been_seen_for_some_frames() -> None:
    objects: list[TrackedObject] = met((RED, BLUE), others=[1, 2])
    said = []
    for index in range(1, 8):
        one, other = (BLUE, RED) if index == 1 else (RED, BLUE)  # the first frame misleads
        now = picture(index, (PLACES[0], one), (PLACES[1], other))
        objects = tell_apart(objects, (), now, index, TOUCH)
        said.append([each.identity for each in objects])
    assert said[0] == [2, 1]
    assert said[-1] == [1, 2]
    assert all(not each.met and each.seen is None for each in objects)
    gone = tell_apart(met((RED,), others=[1, 2]), (), picture(1, (PLACES[0], RED)), 1, TOUCH)
    assert gone[0].met == frozenset()


@pytest.mark.parametrize("stride", [1, 3])
def test_all_looks_are_learned_at_every_stride(stride: int) -> None:
    scene = Scene(lambda _: [Detection(place) for place in PLACES[:2]], config())
    for index in range(0, 15 * stride, stride):
        scene.update(picture(index, *zip(PLACES, (RED, BLUE), strict=False)))
    assert [look.frames for look in scene.looks.values()] == [5, 5]


def test_a_look_is_what_is_not_beside_the_object() -> None:
    """A thin person is who they were before another ground, not who stands before the same one."""

    def look(person: Color, ground: Color) -> Look:
        seen = picture(0, (Box(0, 0, *SIZE), ground), (Box(103, 30, 4, 40), person))
        return Look.at(seen, [Ellipse.from_box(Box(90, 30, 30, 40))])[0]

    known = [look(RED, GREEN), look(BLUE, GRAY)]
    assert costs([look(BLUE, GREEN)], known).argmin() == 1


def test_a_look_has_the_colors_of_both_halves_before_two_grounds() -> None:
    left, right = (Box(0, 0, 105, SIZE[1]), BLUE), (Box(105, 0, 95, SIZE[1]), GREEN)
    shirt, trousers = (Box(103, 30, 4, 20), RED), (Box(103, 50, 4, 20), GRAY)
    seen = picture(0, left, right, shirt, trousers)
    (look,) = Look.at(seen, [Ellipse.from_box(Box(90, 30, 30, 40))])
    upper, lower = look.color.reshape(2, -1)
    assert (upper.max(), lower.max()) == pytest.approx((0.5, 0.5))
    assert upper.argmax() != lower.argmax()


SIDE = 24
GROUND = np.random.default_rng(0).integers(90, 110, (80, 200, 3)).astype(np.uint8)


def striped(index: int, *things: tuple[int, bool]) -> Frame:
    """Return a frame with squares of red stripes, upright or level ones."""
    pixels = GROUND.copy()
    for x, upright in things:
        part = np.full((SIDE, SIDE, 3), 150, np.uint8)
        part[np.arange(SIDE) % 8 < 4] = RED
        pixels[28 : 28 + SIDE, x : x + SIDE] = part.swapaxes(0, 1) if upright else part
    return Frame(index, index / 25, pixels)


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
        found[:] = [Detection(Box(x, 28, SIDE, SIDE)) for x in seen]
        said = {
            each.identity: each
            for each in scene.update(striped(index, (left, False), (right, not alike)))
        }
        if index == 10:
            (first,) = [i for i, track in said.items() if track.ellipse.x < 100]
    assert len(said) == 2
    assert all(track.status is Status.TRACKING for track in said.values())
    assert (said[first].ellipse.x < 100) == (not alike)
