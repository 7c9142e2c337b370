"""How objects begin."""

from __future__ import annotations

from collections.abc import Sequence

import pytest
from msgspec.structs import replace

from motes.core.detection import Detection
from motes.core.geometry import Box
from motes.mot import track_initiation
from motes.mot.scene_config import Initiation
from motes.mot.stages.initiate import initiate
from motes.mot.track_initiation import TrackInitiation
from motes.mot.tracked_object import TrackedObject
from scene_objects import DT, RED, config, picture

PLACE = Box(40, 30, 20, 40)
TWICE = replace(config(), initiation=Initiation(min_hits=2))


def test_a_candidate_that_is_confirmed_becomes_an_object() -> None:
    moved = PLACE._replace(x=44)
    found = [Detection(PLACE)]
    state = TrackInitiation().with_scores(found, found)
    begun, state = initiate(0, 6, state, [], found, picture(0, (PLACE, RED)), TWICE)
    assert (begun, len(state.candidates)) == ([], 1)
    begun, state = initiate(0, 6, state, [], [Detection(moved)], picture(1, (moved, RED)), TWICE)
    (one,) = begun
    assert (one.identity, one.detected, one.last_time) == (7, True, DT)
    assert one.velocity.tolist() == [4 / DT, 0]
    assert state.candidates == ()


def test_a_frame_without_confirmation_ends_a_candidate() -> None:
    found = [Detection(PLACE)]
    state = TrackInitiation().with_scores(found, found)
    for index, there in enumerate((found, [], found)):
        begun, state = initiate(0, 0, state, [], there, picture(index), TWICE)
        assert not begun
    assert len(state.candidates) == 1


def test_a_candidate_with_two_detections_outlives_a_short_gap() -> None:
    """At 25 frames a second, it has not been seen for 0.28 s after seven frames."""
    short = replace(config(), initiation=Initiation(min_hits=3))
    found = [Detection(PLACE)]
    for missing, begins in ((7, True), (8, False)):
        state = TrackInitiation().with_scores(found, found)
        for index, there in enumerate([found, found, *[[]] * missing]):
            _, state = initiate(0, 0, state, [], there, picture(index), short)
        begun, state = initiate(0, 0, state, [], found, picture(2 + missing), short)
        assert bool(begun) is begins
        assert len(state.candidates) == (not begins)


def test_the_lowest_scores_begin_nothing(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(track_initiation, "LOWEST", 0.25)
    found = [Detection(Box(10 + 30 * i, 30, 20, 40), float(i)) for i in range(5)]
    state = TrackInitiation().with_scores(found, found)
    _, state = initiate(0, 0, state, [], found, picture(0), TWICE)
    first = [each.hits[0][1] for each in state.candidates]
    assert first == [each.box for each in found[1:]]  # a quarter lies below the second
    once = replace(config(), initiation=Initiation(min_hits=1))
    begun, _ = initiate(
        0, 0, TrackInitiation().with_scores(found, found), [], found, picture(0), once
    )
    assert len(begun) == 4


def test_a_low_score_confirms_an_object_that_a_surer_one_has_begun() -> None:
    others = [Detection(Box(100 + 30 * i, 30, 20, 40), 5.0) for i in range(5)]
    sure, doubtful = Detection(PLACE, 5.0), Detection(PLACE, 0.0)
    for first, begins in ((sure, True), (doubtful, False)):
        state = TrackInitiation().with_scores([*others, first], [*others, first])
        _, state = initiate(0, 0, state, [], [first], picture(0), TWICE)
        state = state.with_scores([*others, doubtful], [*others, doubtful])
        begun, _ = initiate(0, 0, state, [], [doubtful], picture(1), TWICE)
        assert bool(begun) is begins


def specks(state: TrackInitiation, objects: Sequence[TrackedObject] = ()) -> TrackInitiation:
    """Return a state after 20 frames with a false detection each, of scores below 2."""
    for index in range(21):
        place = Box(100 if index % 2 else 150, 30, 20, 40)
        found = [Detection(place, index / 10)]
        state = state.with_scores(found, found)
        _, state = initiate(0, 0, state, objects, found, picture(index), TWICE)
    return state.with_scores([], [])


@pytest.mark.parametrize(("score", "begins"), [(1.0, False), (3.0, True)])
def test_an_object_is_surer_than_what_nothing_confirms(score: float, begins: bool) -> None:
    sure, found = [Detection(PLACE, 3.0)], [Detection(PLACE, score)]
    state = specks(TrackInitiation().with_scores(sure, []))
    for index in range(21, 24):
        begun, state = initiate(0, 0, state, [], found, picture(index), TWICE)
        assert bool(begun) == (begins and index % 2 == 0)
    begun, state = initiate(0, 0, state, [], sure, picture(24), TWICE)
    assert begun


def test_where_sure_detections_are_not_confirmed_half_of_the_others_are_sure_enough() -> None:
    """What moves too fast to be confirmed is as sure as what does not."""
    slow = [Detection(PLACE, score) for score in (0.5, 1.0, 3.0)]
    assert specks(TrackInitiation().with_scores(slow, [])).least == 1.0


def test_random_numbers_depend_on_seed_and_identity_alone() -> None:
    once = replace(config(), initiation=Initiation(min_hits=1))
    boxes = [Box(10, 30, 20, 40), Box(100, 30, 20, 40)]

    def drawn(seed: int, created: int, some: list[Box]) -> list[float]:
        found = [Detection(box) for box in some]
        state = TrackInitiation().with_scores(found, found)
        begun, _ = initiate(seed, created, state, [], found, picture(0), once)
        return [each.rng.random() for each in begun]

    first, second = drawn(3, 0, boxes)
    assert first != second
    assert drawn(3, 1, boxes[:1]) == [second]
    assert drawn(4, 0, boxes)[0] != first
