"""How objects begin: confirmed by detections, or announced by another camera."""

from collections.abc import Sequence

import numpy as np
import pytest
from msgspec.structs import replace

from motes.core.detection import Detection
from motes.core.geometry import Box, Ellipse, iou
from motes.mot import Expected, track_initiation
from motes.mot.scene import SceneState, step
from motes.mot.scene_config import Initiation
from motes.mot.stages.admit import admit
from motes.mot.stages.initiate import initiate
from motes.mot.track_initiation import TrackInitiation
from motes.mot.tracked_object import TrackedObject
from scene_objects import DT, RED, config, picture, visible

PLACE = Box(40, 30, 20, 40)
TWICE, THRICE = (replace(config(), initiation=Initiation(min_hits=n)) for n in (2, 3))


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


@pytest.mark.parametrize(
    ("places", "begins"),
    [
        ((0, 20, 40), True),
        ((0, 20, 52), False),
        ((0, 20, None, 60), True),  # not detected in a frame
        ((0, 6, 0), True),  # it trembles
    ],
)
def test_who_moves_by_a_width_a_frame_is_confirmed_where_it_goes_on(
    places: Sequence[int | None], begins: bool
) -> None:
    """An overlap of 0.3 is left where 20 pixels of width are off by 10."""
    begun, state = list[TrackedObject](), TrackInitiation()
    for index, x in enumerate(places):
        found = [] if x is None else [Detection(PLACE._replace(x=10 + x))]
        state = state.with_scores(found, found)
        assert not begun
        begun, state = initiate(0, 0, state, [], found, picture(index), config())
    assert bool(begun) is begins


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
        begun, state = initiate(0, 0, state, [], found, picture(index), THRICE)
        assert bool(begun) == (begins and index == 22)  # one detection less is enough
    begun, state = initiate(0, 0, state, [], sure, picture(24), THRICE)
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


BOX = Box(60, 40, 20, 30)
FRAME = picture(3, (BOX, RED))
ANNOUNCED = Ellipse.from_box(BOX)


def expected(at: Ellipse = ANNOUNCED, *, certain: bool = True, spread: float = 2.0) -> Expected:
    """Return that something red is expected, moving to the right."""
    spreads = spread, spread, 0.3, 0.3, 0.0
    samples = np.random.default_rng(0).normal(at, spreads, (50, 5))
    return Expected(
        7, samples, np.array([50.0, 0.0]), Expected.CUE.learn(FRAME, ANNOUNCED), certain
    )


def admitted(*free: Box, objects: tuple[Box, ...] = (), frame=FRAME, **how):  # type: ignore[no-untyped-def]
    there = [visible(n + 1, frame, box) for n, box in enumerate(objects)]
    found = [Detection(box) for box in free]
    return admit(0, len(there), [expected(**how)], there, found, frame, config())


@pytest.mark.parametrize("certain", [True, False])
def test_an_expected_object_begins_with_its_first_detection(certain: bool) -> None:
    other = Box(150, 40, 20, 30)
    (begun,), keys, free = admitted(other, BOX, certain=certain)
    assert begun.detected
    assert begun.track.box == pytest.approx(BOX)
    assert begun.public_track.velocity == (50.0, 0.0)
    assert keys == {begun.identity: 7}
    assert [each.box for each in free] == [other]
    assert begun.identity == 1


def test_its_filter_begins_with_the_given_samples_and_model() -> None:
    (begun,), *_ = admitted()
    np.testing.assert_array_equal(begun.state.models["color"].histogram, expected().model.histogram)
    centers = config().tracker.motion.ellipses(begun.state.states)[:, :2]
    np.testing.assert_allclose(centers, expected().samples[:, :2])


def test_a_certain_one_needs_no_detection() -> None:
    (begun,), *_ = admitted()
    assert not begun.detected
    assert iou(np.array(begun.track.box), np.array([BOX]))[0] > 0.7
    assert admitted(certain=False) == ([], {}, [])


def test_a_scene_begins_it_two_frames_before_a_birth() -> None:
    for arriving, first in ([expected()], 0), ([], 2):
        state = SceneState()
        for index in range(3):
            frame = picture(index, (BOX, RED))
            state, info = step(0, state, frame, DT, [Detection(BOX)], config(), arriving)
            arriving = []
            assert bool(info.tracks) is (index >= first)


def test_a_part_at_the_border_is_enough() -> None:
    """The camera sees the first 6 of 20 columns; most samples have their centers outside."""
    shown = Box(0, 40, 6, 30)
    frame = picture(3, (shown, RED))
    (begun,), *_ = admitted(shown, frame=frame, at=ANNOUNCED._replace(x=-4.0))
    assert begun.detected
