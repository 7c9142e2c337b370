"""Being lost and found again, by evidence alone."""

from __future__ import annotations

import pytest

from motes.core.track import Status
from motes.sot.discriminative.standing import FRAMES, Standing

TRACKED = Standing()
LOST = Standing(status=Status.LOST, missed=FRAMES)


def after(
    evidence: list[float], before: Standing = TRACKED, jumps: tuple[int, ...] = ()
) -> list[Standing]:
    """Return what follows from one frame after the other; some are of a place jumped to."""
    told = []
    for index, log_odds in enumerate(evidence):
        before = before.after(log_odds, jumped=index in jumps)
        told.append(before)
    return told


def statuses(told: list[Standing]) -> str:
    return "".join(standing.status[0] for standing in told)


def test_lost_after_three_frames_in_a_row() -> None:
    told = after([-1, -1, 1, -1, -1, -1, -1])
    assert statuses(told) == "tttttls"
    assert [standing.missed for standing in told] == [1, 2, 0, 1, 2, 3, 4]


def test_found_after_three_frames_in_a_row_and_believed_from_then_on() -> None:
    told = after([1, 1, -1, 1, 1, 1, 1], LOST)
    assert statuses(told) == "ssssstt"
    assert [standing.missed for standing in told] == [4, 5, 6, 7, 8, 0, 0]


def test_one_bad_frame_is_forgiven_at_once() -> None:
    told = after([2, -3, 2])
    assert statuses(told) == "ttt"
    assert [standing.missed for standing in told] == [0, 1, 0]


def test_a_jump_begins_anew_to_count() -> None:
    assert statuses(after([1, 1, 1, 1, 1], LOST, jumps=(2,))) == "sssst"
    assert [standing.missed == 0 for standing in after([1, 1, 1, 1], LOST, jumps=(0,))] == [
        False,
        False,
        True,
        True,
    ]


def test_a_jump_in_a_frame_that_was_missed_only_now_is_believed_at_once() -> None:
    (standing,) = after([1.5], jumps=(0,))
    assert (standing.status, standing.missed) == (Status.TRACKING, 0)


@pytest.mark.parametrize(("log_odds", "missed"), [(0.01, 0), (0.0, 1), (-0.01, 1)])
def test_the_threshold_is_where_the_target_is_as_likely_there_as_not(
    log_odds: float, missed: int
) -> None:
    assert Standing().after(log_odds, jumped=False).missed == missed
