"""Targets of one video: no two are at one place, and who is hidden by another is found again."""

from pathlib import Path

import numpy as np
import pytest
from msgspec.structs import replace
from numpy.typing import NDArray

from motes import Discriminative, Status, Track, Tracker, Trackers
from motes.core.frame import FRAME_INTERVAL, Frame
from motes.core.geometry import Ellipse, iou
from motes.sot.discriminative.exclusion import Claim, Taken, excluded
from motes.sot.discriminative.standing import Standing
from motes.sot.discriminative.state import DiscriminativeState

FRONT = (62, 42, 24, 40)
"""The box of who stands in front."""
FRAMES, HIDDEN = 64, 24
"""Frames of the film, and how many of them the other one stays hidden."""


def at(x: float, y: float = 50.0) -> Ellipse:
    return Ellipse(x, y, 10.0, 20.0)


def claim(before: float, now: float, against: float, *, missed: bool = False) -> Claim:
    return Claim(at(before), at(now), missed, against)


@pytest.mark.parametrize(
    ("claims", "elsewhere"),
    [
        ([claim(20, 22, 1), claim(80, 82, 2)], {}),
        ([claim(20, 40, 1), claim(60, 42, 2)], {1: [40]}),
        ([claim(20, 40, 3), claim(60, 42, 2)], {0: [42]}),
        ([claim(40, 41, 1), claim(42, 42, 2)], {}),  # one was corrected to be upon the other
        ([claim(40, 41, 1), claim(42, 42, 2, missed=True)], {1: [41]}),
        ([claim(20, 40, 1), claim(60, 54, 2)], {}),  # beside it, half covered
        ([claim(20, 40, 1), claim(60, 50, 2, missed=True)], {1: [40]}),  # not out yet
        ([claim(20, 40, 1), claim(60, 54, 2, missed=True)], {}),  # it is
        ([claim(20, 40, 1), claim(60, 44, 2), claim(90, 49, 3)], {1: [40]}),  # room for the third
        ([claim(20, 40, 1), claim(60, 41, 2), claim(90, 42, 3)], {1: [40], 2: [40]}),
    ],
)
def test_who_has_to_be_elsewhere(claims: list[Claim], elsewhere: dict[int, list[float]]) -> None:
    found = excluded(dict(enumerate(claims)))
    assert {n: [place.x for place in taken.places] for n, taken in found.items()} == elsewhere
    for n, taken in found.items():
        assert taken.holds(claims[n].now)
        assert not taken.holds(at(150.0))
    assert excluded({}) == {}


def test_who_lie_upon_each_other_take_no_place_from_each_other() -> None:
    """But they take those of others, and others take theirs."""
    claims = {1: claim(20, 40, 3), 4: claim(60, 42, 1, missed=True), 6: claim(90, 41, 5)}
    assert {*excluded(claims)} == {1, 6}
    found = excluded(claims, {(1, 4)})
    assert {n: [place.x for place in taken.places] for n, taken in found.items()} == {6: [42, 40]}


def film() -> list[Frame]:
    """Return frames in which somebody walks behind another one, stays there, and comes out."""
    rng = np.random.default_rng(0)
    ground = rng.integers(90, 150, (15, 20, 3)).repeat(8, axis=0).repeat(8, axis=1)

    def person(*colors: tuple[int, int, int]) -> NDArray[np.int64]:
        cloth = rng.integers(-30, 30, (10, 6, 1)).repeat(4, axis=0).repeat(4, axis=1)
        out: NDArray[np.int64] = cloth + np.repeat(colors, 20, axis=0)[:, None]
        return out

    front = person((170, 60, 60), (60, 60, 140))
    other = person((170, 60, 60), (60, 140, 60))
    frames = []
    for index in range(FRAMES):
        pixels = ground.copy()
        left = place(index)
        pixels[40:80, left : left + 24] = other
        pixels[42:82, 62:86] = front
        frames.append(Frame(index, index * FRAME_INTERVAL, pixels.astype(np.uint8)))
    return frames


def place(index: int) -> int:
    """Return the left border of the box of who walks."""
    return 20 + 2 * (min(index, 20) + max(0, index - 20 - HIDDEN))


@pytest.mark.slow
@pytest.mark.parametrize("threads", [1, 2])
def test_who_comes_out_from_behind_another_one_is_found_again(threads: int) -> None:
    frames, tracks = film(), list[list[Track]]()
    with Trackers(seed=1, threads=threads) as trackers:
        tracks.append(trackers.init(frames[0], [(20, 40, 24, 40), FRONT]))
        tracks += [trackers.update(frame) for frame in frames[1:]]
    for walker, other in tracks:
        assert iou(other.box, FRONT) > 0.7
        at_one = iou(walker.box, other.box) > 0.5
        assert not (at_one and min(walker.confidence, other.confidence) > 0.5)
    walker, _ = tracks[-1]
    assert iou(walker.box, (place(FRAMES - 1), 40, 24, 40)) > 0.7


def test_targets_that_do_not_meet_are_followed_as_if_alone() -> None:
    frames = film()[:8]
    boxes = [(20, 40, 24, 40), FRONT, (120, 20, 24, 40)]
    together = Trackers(seed=3)
    tracks = [together.init(frames[0], boxes), *map(together.update, frames[1:])]
    for n, box in enumerate(boxes):
        alone = Tracker(seed=3 + n)
        own = [alone.init(frames[0], box), *map(alone.update, frames[1:])]
        assert [each[n].ellipse for each in tracks] == [track.ellipse for track in own]
        assert [each[n].confidence for each in tracks] == [track.confidence for track in own]


SHIRT, PERSON = (60, 44, 24, 20), (60, 36, 24, 44)


@pytest.mark.parametrize("added", [False, True])
def test_a_shirt_that_was_hidden_is_found_again_upon_its_person(
    added: bool, tmp_path: Path
) -> None:
    """It never comes out from behind him; also if the trackers are saved meanwhile."""
    rng = np.random.default_rng(0)
    ground = rng.integers(60, 200, (15, 20, 3)).repeat(8, axis=0).repeat(8, axis=1)
    cloth = rng.integers(0, 255, (11, 6, 3)).repeat(4, axis=0).repeat(4, axis=1)
    ground[36:80, 60:84] = cloth
    trackers = Trackers()
    for index in range(30):
        pixels = ground.copy()
        if 5 <= index < 12:
            pixels[44:64, 56:88] = 128  # a board
        frame = Frame(index, index * FRAME_INTERVAL, pixels.astype(np.uint8))
        if index == 0:
            trackers.init(frame, [PERSON] if added else [PERSON, SHIRT])
            if added:
                trackers.add(SHIRT)
            trackers.save(tmp_path / "two.motes")
            trackers = Trackers.load(tmp_path / "two.motes")
        else:
            tracks = trackers.update(frame)
        if index == 11:
            assert tracks[1].status is not Status.TRACKING
    assert [track.status for track in tracks] == [Status.TRACKING] * 2
    assert iou(tracks[0].box, PERSON) > 0.7
    assert iou(tracks[1].box, SHIRT) > 0.7


def test_who_was_missed_or_told_already_gives_way() -> None:
    """By one log odd, so that small differences of looks do not exchange two who look alike."""
    config, frame = Discriminative(), film()[0]
    rng = np.random.default_rng(0)
    start, _ = config.init(rng, frame, Ellipse(50.0, 50.0, 10.0, 20.0))

    def state(x: float, distance: float, *, missed: int = 0) -> DiscriminativeState:
        belief = replace(start.belief, distance=distance)
        standing = Standing(missed=missed, confirmed=1)
        return replace(start, ellipse=at(x), belief=belief, standing=standing)

    here, near = [state(50, 0.01), state(50, 0.05)], [state(50, 0.01), state(60, 0.05)]
    assert {*config.displaced([state(20, 0), state(80, 0)], here)} == {1}
    assert {*config.displaced([state(20, 0, missed=1), state(80, 0)], here)} == {0}
    apart = [state(20, 0), state(80, 0)]
    assert config.displaced(apart, near) == {}
    going = replace(start.motion, seen=1, velocity=np.array([-30.0, 0.0]))  # and less like itself
    twin = [apart[0], replace(apart[1], motion=going)]
    standing = replace(twin[0], motion=replace(going, velocity=np.zeros(2)))
    assert {*config.displaced([standing, twin[1]], here)} == {0}  # which leaps
    told = replace(apart[0], taken=Taken((at(150.0),)))
    again = config.displaced([told, apart[1]], near)
    assert [place.x for place in again[0].taken.places] == [150.0, 60.0]
