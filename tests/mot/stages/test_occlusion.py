"""Which objects are occluded, and by what; how they reappear, and when they end."""

import math

import numpy as np
import pytest
from msgspec.structs import replace

from motes import Box, Detection, Status
from motes.mot.scene_config import Occlusion
from motes.mot.stages.mark_occluded import mark_occluded
from motes.mot.stages.reidentify import reidentify
from motes.mot.stages.report import report
from motes.mot.tracked_object import TrackedObject
from scene_objects import (
    BLUE,
    DT,
    RED,
    config,
    occluded,
    picture,
    statuses,
    undetected,
    visible,
    with_look,
)

PLACE, OVER = Box(40, 30, 20, 40), Box(48, 30, 20, 40)
FRAME = picture(1, (PLACE, RED))


def seen(identity: int, box: Box, distance: float = 0.1) -> TrackedObject:
    """Return an undetected object that its filter recognizes, at a distance from its model."""
    each = undetected(identity, picture(0, (box, RED)), box)
    return replace(each, track=replace(each.track, distance=distance))


def test_a_detected_object_occludes_an_undetected_one() -> None:
    front = seen(2, OVER).detect(OVER, FRAME.time)
    after = mark_occluded([seen(1, PLACE), front], FRAME, Occlusion())
    assert statuses(after) == {1: Status.OCCLUDED, 2: Status.TRACKING}
    assert after[0].occluded_by == 2
    assert after[0].confidence == 0


def test_the_confidence_is_how_steadily_an_object_is_detected_while_it_can_be_seen() -> None:
    steady = visible(1, FRAME, PLACE)
    for _ in range(100):
        steady = steady.tallied(DT)
    assert steady.steadiness == pytest.approx(1, abs=0.02)
    missed, hidden = steady.predict(DT), steady.predict(DT).occlude(None)
    for _ in range(25):
        missed, hidden = missed.tallied(DT), hidden.tallied(DT)
    assert missed.steadiness == pytest.approx(steady.steadiness / math.e)
    assert hidden.steadiness == steady.steadiness
    assert hidden.confidence == 0
    assert 0.5 < missed.confidence < steady.confidence - 0.2
    assert steady.confidence < replace(steady, moved=True).confidence < 0.95
    unlike = replace(steady, track=replace(steady.track, distance=0.9, confidence=0.1))
    assert unlike.confidence == steady.confidence == steady.public_track.confidence


@pytest.mark.parametrize(("first", "second", "hidden"), [(0.3, 0.2, 1), (0.2, 0.3, 2)])
def test_of_two_undetected_objects_the_worse_match_is_occluded(
    first: float, second: float, hidden: int
) -> None:
    after = mark_occluded([seen(1, PLACE, first), seen(2, OVER, second)], FRAME, Occlusion())
    assert [each.identity for each in after if each.occluded] == [hidden]


def test_an_object_that_covers_too_little_occludes_nothing() -> None:
    objects = [seen(1, PLACE), seen(2, OVER).detect(OVER, FRAME.time)]  # 12 of 20 columns
    assert mark_occluded(objects, FRAME, Occlusion(overlap=0.61)) == objects
    assert mark_occluded(objects, FRAME, Occlusion(overlap=0.59))[0].occluded


def test_scenery_occludes_what_fails_the_appearance_rule_or_is_too_long_undetected() -> None:
    each = seen(1, PLACE)
    failed = replace(each, state=replace(each.state, frames_missed=1))
    for undetected_one, frame in ((failed, FRAME), (each, picture(4))):
        (after,) = mark_occluded([undetected_one], frame, Occlusion())
        assert (after.track.status, after.occluded_by) == (Status.OCCLUDED, None)
    assert mark_occluded([each], picture(3), Occlusion()) == [each]  # 0.12 s


@pytest.mark.parametrize("hidden", [False, True])
@pytest.mark.parametrize(("color", "visible"), [(RED, True), (BLUE, False)])
@pytest.mark.parametrize("off", [0, 3])
def test_who_looks_as_when_it_was_last_clear_is_visible_though_not_detected(
    off: int, color: tuple[int, int, int], visible: bool, hidden: bool
) -> None:
    """It is some pixels beside where it should be, long after its last detection."""
    moved = PLACE._replace(x=PLACE.x + 10)
    there = moved._replace(x=moved.x + off)
    frame = picture(30, (there, color))
    begin = (occluded if hidden else undetected)(1, picture(0, (PLACE, RED)), PLACE)
    fast = replace(with_look(begin, RED), velocity=np.array([10 / DT, 0.0])).predict(DT)
    fast = fast if hidden else fast.observe(frame, DT, learn=False)
    (after,) = mark_occluded([fast], frame, Occlusion())
    assert after.occluded is not visible
    assert after.track.box == pytest.approx(there if visible else moved, abs=0.5)
    assert (after.track.frame, after.track.time, after.detected) == (30, frame.time, False)
    assert (after.confidence > 0.5) is visible
    states = after.tracker.motion.ellipses(after.state.states)
    assert states[:, 0].mean() == pytest.approx(after.track.ellipse.x, abs=3)


def test_who_looks_like_itself_is_not_hidden_by_who_covers_it_and_one_frame_is_no_look() -> None:
    front = seen(2, OVER).detect(OVER, FRAME.time)
    for frames, status in ((5, Status.TRACKING), (4, Status.OCCLUDED)):
        after = mark_occluded([with_look(seen(1, PLACE), RED, frames), front], FRAME, Occlusion())
        assert statuses(after) == {1: status, 2: Status.TRACKING}


@pytest.mark.parametrize(("gain", "step"), [(0.5, 0.0), (1.5, -3.0)])
def test_a_step_beside_where_it_should_be_must_look_clearly_more_like_the_object(
    monkeypatch: pytest.MonkeyPatch, gain: float, step: float
) -> None:
    """Else it stays behind with the part of it that somebody does not cover yet."""
    unlikely = np.array([[10.0], [10.0 - gain], [10.0], [10.0], [10.0]])
    monkeypatch.setattr("motes.mot.stages.mark_occluded.costs", lambda *_: unlikely.copy())
    (after,) = mark_occluded([with_look(seen(1, PLACE), RED)], FRAME, Occlusion())
    assert after.track.box.x - PLACE.x == pytest.approx(step)


def test_where_the_detector_did_not_look_only_who_is_covered_is_occluded() -> None:
    each = seen(1, PLACE)
    failed = replace(each, state=replace(each.state, frames_missed=1))
    front = seen(2, OVER).detect(OVER, FRAME.time)
    for one in (failed, with_look(failed, BLUE)):
        (after,) = mark_occluded([one], FRAME, Occlusion(), looked=False)
        assert (after.track.status, after.detected) == (Status.TRACKING, False)
        assert after.track.box == pytest.approx(PLACE)
        assert mark_occluded([one], FRAME, Occlusion())[0].occluded
        assert mark_occluded([one, front], FRAME, Occlusion(), looked=False)[0].occluded


def test_detected_objects_are_never_occluded_and_occluded_ones_occlude_nothing() -> None:
    both = [seen(1, PLACE).detect(PLACE, FRAME.time), seen(2, OVER).detect(OVER, FRAME.time)]
    assert mark_occluded(both, FRAME, Occlusion()) == both
    better, worse = seen(1, PLACE, 0.1), seen(2, OVER, 0.2)
    failed = replace(better, state=replace(better.state, frames_missed=1))
    after = mark_occluded([failed, worse], FRAME, Occlusion())
    assert statuses(after) == {1: Status.OCCLUDED, 2: Status.TRACKING}


def test_occluded_objects_go_on_with_their_velocity() -> None:
    before = replace(occluded(1, picture(0, (PLACE, RED)), PLACE), velocity=np.array([50.0, 0.0]))
    (after,) = mark_occluded([before.predict(DT)], FRAME, Occlusion())
    assert after.track.box == pytest.approx(PLACE._replace(x=PLACE.x + 50 * DT))
    assert (after.track.frame, after.track.time) == (FRAME.index, FRAME.time)


BEFORE = picture(0, (PLACE, RED))


def test_an_object_is_visible_again_where_it_is_detected() -> None:
    near, far = PLACE._replace(x=50), PLACE._replace(x=150)
    frame = picture(5, (near, RED), (far, RED))
    found = [Detection(far), Detection(near)]
    (after,), free = reidentify([occluded(1, BEFORE, PLACE)], found, [], frame, DT, config())
    assert after.track.box == pytest.approx(near)
    assert (after.track.status, after.detected, after.last_time) == (
        Status.TRACKING, True, frame.time,
    )  # fmt: skip
    assert after.confidence > 0.5
    assert free == [found[0]]


@pytest.mark.parametrize(("surprise", "reached"), [(0.005, False), (0.05, True)])
def test_the_gate_grows_with_time_the_faster_the_less_evenly_an_object_moved(
    surprise: float, reached: bool
) -> None:
    away = PLACE._replace(x=78)  # more than two mean half-axes
    hidden = replace(occluded(1, BEFORE, PLACE), surprise=(surprise, surprise))
    for index, found in ((2, False), (15, reached)):
        frame = picture(index, (away, RED))
        _, free = reidentify([hidden], [Detection(away)], [], frame, DT, config())
        assert (not free) == found


def test_the_variance_of_a_forecast_is_that_of_simulated_ones() -> None:
    """Of paths whose velocity follows each error by the share that it follows a detection by."""
    rng, frames, kept = np.random.default_rng(0), 12, 0.8
    errors = rng.normal(0, 3, (20_000, frames))
    velocity = np.cumsum((1 - kept) * errors, axis=1) - (1 - kept) * errors
    ends = (velocity + errors).sum(axis=1)
    one = replace(occluded(1, BEFORE, PLACE), surprise=(9.0, 9.0))
    variance = one.variance(one.last_time + frames * DT, DT, kept)
    assert variance == pytest.approx([ends.var()] * 2, rel=0.05)


@pytest.mark.parametrize("axis", [0, 1])
def test_surprise_is_how_far_detections_are_off(axis: int) -> None:
    def follow(one: TrackedObject, off: float) -> TrackedObject:
        place = PLACE._replace(**{"xy"[axis]: PLACE[axis] + off})
        return one.predict(DT).detect(place, 0).update_velocity(0.8, DT)

    even = uneven = visible(1, BEFORE, PLACE)
    for n in range(1, 40):
        even, uneven = follow(even, 2 * n), follow(uneven, 2 * n + 4 * (-1) ** n)
    assert max(even.surprise) < 0.01 < uneven.surprise[axis]
    assert uneven.surprise[1 - axis] < 0.01


def test_particles_move_and_grow_with_their_object() -> None:
    one = replace(visible(1, BEFORE, PLACE), velocity=np.array([50.0, 25.0]))
    taller = Box(PLACE.x + 50 * DT, PLACE.y + 25 * DT, PLACE.width, 2 * PLACE.height)
    before, moved, grown = (
        one.tracker.motion.ellipses(each.state.states)
        for each in (one, one.predict(DT), one.predict(DT).detect(taller, 0))
    )
    np.testing.assert_allclose(moved, before + np.array((50 * DT, 25 * DT, 0, 0, 0)))
    lower = (0, PLACE.height / 2, 0, 0, 0)
    np.testing.assert_allclose(grown, moved * (1, 1, 1, 2, 1) + lower)


def test_an_object_may_reappear_beside_its_occluder() -> None:
    """The occluder has carried it away, much farther than its own gate reaches."""
    away = PLACE._replace(x=150)
    frame = picture(2, (away, RED))
    occluder = visible(2, frame, away)
    for by, found in ((None, False), (2, True)):
        objects = [occluded(1, BEFORE, PLACE, by), occluder]
        _, free = reidentify(objects, [Detection(away)], [], frame, DT, config())
        assert (not free) == found


def test_a_detection_of_another_color_is_no_object_that_was_there() -> None:
    away = PLACE._replace(x=60)
    for color, found in ((RED, True), (BLUE, False)):
        frame = picture(2, (away, color))
        _, free = reidentify(
            [occluded(1, BEFORE, PLACE)], [Detection(away)], [], frame, DT, config()
        )
        assert (not free) == found


def test_nobody_begins_where_one_who_looks_like_another_is_before_an_object() -> None:
    over, away = PLACE._replace(x=58), PLACE._replace(x=90)  # an overlap of 2 columns
    frame = picture(2, (over, BLUE), (away, BLUE))
    found = [Detection(over), Detection(away)]
    hidden = with_look(occluded(1, BEFORE, PLACE), RED)
    after, free = reidentify([hidden], found, [], frame, DT, config())
    assert (after, free) == ([hidden], found[1:])
    assert reidentify([], found, found[1:], frame, DT, config()) == ([], found[:1])


def test_visible_objects_get_none() -> None:
    objects, found = [visible(1, BEFORE, PLACE)], [Detection(PLACE)]
    assert reidentify(objects, found, [], picture(1), DT, config()) == (objects, found)


LAST_SEEN = picture(100, (PLACE, RED))  # at 4 s


def last_frame(box: Box = PLACE, covered: bool = False) -> int:
    """Return in how many frames an object that was last detected at 4 s is reported."""
    each = occluded(1, picture(100, (box, RED)), box)
    other = visible(2, LAST_SEEN, PLACE)
    for age in range(1, 300):
        frame = picture(100 + age)
        others = [replace(other, last_time=frame.time)] if covered else []
        tracks, staying = report([each, *others], frame, 0.0, config())
        if tracks[0].gone:
            assert each not in staying
            return age - 1
        assert staying[0] is each
    raise AssertionError("never")


@pytest.mark.slow
def test_an_object_is_kept_for_three_seconds_and_twice_as_long_behind_another() -> None:
    assert last_frame() == pytest.approx(3 / 0.04, abs=1)
    assert last_frame(covered=True) == pytest.approx(6 / 0.04, abs=1)


def test_an_occluded_object_that_ends_covers_nothing() -> None:
    """Neither is visible, so both end in the same frame."""
    both = [occluded(identity, LAST_SEEN, PLACE, by=3 - identity) for identity in (1, 2)]
    tracks, staying = report(both, picture(176), 0.0, config())
    assert [(each.gone, each.occluded_by) for each in tracks] == [(True, None)] * 2
    assert staying == []


@pytest.mark.parametrize(
    ("left", "status", "by"), [(40, "occluded", 3), (53, "occluded", 3), (55, "lost", None)]
)
def test_what_is_hidden_has_an_occluder_or_is_lost(left: int, status: str, by: int | None) -> None:
    """The box of the visible object covers 20, 7 or 5 of 20 columns; 6 are asked for."""
    front = visible(3, picture(100, (Box(left, 30, 20, 40), RED)), Box(left, 30, 20, 40))
    hidden = occluded(1, LAST_SEEN, PLACE, by=3)
    (_, track), staying = report([front, hidden], LAST_SEEN, 0.0, config())
    assert (track.status, track.occluded_by, track.sought) == (status, by, by is None)
    assert not track.gone
    assert staying == [front, hidden]


@pytest.mark.parametrize(("best", "stays"), [(0.4, False), (0.5, True)])
def test_an_object_that_was_never_sure_enough_is_gone(best: float, stays: bool) -> None:
    one = replace(visible(3, LAST_SEEN, PLACE), best=best)
    (track,), staying = report([one], LAST_SEEN, 0.5, config())
    assert (track.gone, staying) == (not stays, [one] * stays)
