"""How objects begin."""

from __future__ import annotations

from msgspec.structs import replace

from motes.core.detection import Detection
from motes.core.geometry import Box
from motes.mot.detection_outcome import DetectionOutcome
from motes.mot.scene_config import Initiation
from motes.mot.stages.initiate import initiate
from motes.mot.track_initiation import TrackInitiation
from scene_objects import DT, RED, config, picture

PLACE = Box(40, 30, 20, 40)
TWICE = replace(config(), initiation=Initiation(min_hits=2))


def test_a_candidate_that_is_confirmed_becomes_an_object() -> None:
    moved = PLACE._replace(x=44)
    found = [Detection(PLACE)]
    state = TrackInitiation(created=6).with_scores(found)
    begun, state, log = initiate(0, state, found, picture(0, (PLACE, RED)), TWICE)
    assert (begun, [each.outcome for each in log]) == ([], [DetectionOutcome.CANDIDATE])
    begun, state, log = initiate(0, state, [Detection(moved)], picture(1, (moved, RED)), TWICE)
    (one,) = begun
    assert (one.identity, one.detected, one.first_time, one.last_time) == (7, True, 0.0, DT)
    assert one.velocity.tolist() == [4 / DT, 0]
    assert [(each.outcome, each.identity) for each in log] == [(DetectionOutcome.BORN, 7)]
    assert (state.created, state.candidates) == (7, ())


def test_a_frame_without_confirmation_ends_a_candidate() -> None:
    found = [Detection(PLACE)]
    state = TrackInitiation().with_scores(found)
    for index, there in enumerate((found, [], found)):
        begun, state, _ = initiate(0, state, there, picture(index), TWICE)
        assert not begun
    assert len(state.candidates) == 1


def test_the_lowest_scores_begin_nothing() -> None:
    found = [Detection(Box(10 + 30 * i, 30, 20, 40), float(i)) for i in range(5)]
    state = TrackInitiation().with_scores(found)
    _, state, log = initiate(0, state, found, picture(0), TWICE)
    doubtful = [each.detection for each in log if each.outcome is DetectionOutcome.DOUBTFUL]
    assert doubtful == found[:1]  # a quarter lies below the second
    assert len(state.candidates) == 4


def test_random_numbers_depend_on_seed_and_identity_alone() -> None:
    once = replace(config(), initiation=Initiation(min_hits=1))
    boxes = [Box(10, 30, 20, 40), Box(100, 30, 20, 40)]

    def drawn(seed: int, created: int, some: list[Box]) -> list[float]:
        found = [Detection(box) for box in some]
        state = TrackInitiation(created=created).with_scores(found)
        begun, *_ = initiate(seed, state, found, picture(0), once)
        return [each.rng.random() for each in begun]

    first, second = drawn(3, 0, boxes)
    assert first != second
    assert drawn(3, 1, boxes[:1]) == [second]
    assert drawn(4, 0, boxes)[0] != first
