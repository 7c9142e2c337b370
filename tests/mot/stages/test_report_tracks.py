"""Tracks of a frame, and which objects end."""

from __future__ import annotations

import pytest
from msgspec.structs import replace

from motes.core.geometry import Box
from motes.mot.stages.report import report
from scene_objects import RED, config, occluded, picture, visible

PLACE = Box(40, 30, 20, 40)
BEFORE = picture(100, (PLACE, RED))  # at 4 s


def last_frame(box: Box = PLACE, covered: bool = False) -> int:
    """Return in how many frames an object that was last detected at 4 s is reported."""
    each = occluded(1, picture(100, (box, RED)), box)
    other = visible(2, BEFORE, PLACE)
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
def test_an_object_is_kept_for_three_seconds() -> None:
    assert last_frame() == pytest.approx(3 / 0.04, abs=1)


@pytest.mark.slow
def test_behind_a_visible_object_it_is_kept_twice_as_long() -> None:
    assert last_frame(covered=True) == pytest.approx(6 / 0.04, abs=1)


def test_an_occluded_object_that_ends_covers_nothing() -> None:
    """Neither is visible, so both end in the same frame."""
    both = [occluded(identity, BEFORE, PLACE, by=3 - identity) for identity in (1, 2)]
    tracks, staying = report(both, picture(176), 0.0, config())
    assert [(each.gone, each.occluded_by) for each in tracks] == [(True, None)] * 2
    assert staying == []


@pytest.mark.parametrize(
    ("left", "status", "by"), [(40, "occluded", 3), (53, "occluded", 3), (55, "lost", None)]
)
def test_what_is_hidden_has_an_occluder_or_is_lost(left: int, status: str, by: int | None) -> None:
    """The box of the visible object covers 20, 7 or 5 of 20 columns; 6 are asked for."""
    front = visible(3, picture(100, (Box(left, 30, 20, 40), RED)), Box(left, 30, 20, 40))
    hidden = occluded(1, BEFORE, PLACE, by=3)
    (_, track), staying = report([front, hidden], BEFORE, 0.0, config())
    assert (track.status, track.occluded_by, track.sought) == (status, by, by is None)
    assert not track.gone
    assert staying == [front, hidden]


def test_tracks_say_what_is_known_of_an_object() -> None:
    objects = [visible(3, BEFORE, PLACE), occluded(1, BEFORE, PLACE, by=3)]
    tracks, staying = report(objects, BEFORE, 0.0, config())
    assert staying == objects
    assert [(t.identity, t.occluded_by, t.detected) for t in tracks] == [
        (3, None, True),
        (1, 3, False),
    ]
    assert [t.box for t in tracks] == [each.track.box for each in objects]


@pytest.mark.parametrize(("best", "stays"), [(0.4, False), (0.5, True)])
def test_an_object_that_was_never_sure_enough_is_gone(best: float, stays: bool) -> None:
    one = replace(visible(3, BEFORE, PLACE), best=best)
    (track,), staying = report([one], BEFORE, 0.5, config())
    assert (track.gone, staying) == (not stays, [one] * stays)
