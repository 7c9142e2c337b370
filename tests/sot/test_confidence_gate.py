"""Being lost and found again, by certainties alone."""

from __future__ import annotations

import pytest

from motes.core.track import Status
from motes.sot.discriminative.confidence_gate import REFERENCE_FRAMES, ConfidenceGate, TargetStatus

CLEAR = TargetStatus(reference=0.9, seen=REFERENCE_FRAMES)
LOST = CLEAR._replace(status=Status.LOST, frames_missed=3)


def after(
    certainties: list[float],
    before: TargetStatus = CLEAR,
    jumps: tuple[int, ...] = (),
    responses: list[float] | None = None,
) -> list[tuple[TargetStatus, bool, bool]]:
    """Return what is judged of one certainty after the other; some are of a place jumped to."""
    told = []
    for index, certainty in enumerate(certainties):
        response = responses[index] if responses else 0.0
        told.append(ConfidenceGate().update(before, certainty, response, jumped=index in jumps))
        before = told[-1][0]
    return told


def statuses(told: list[tuple[TargetStatus, bool, bool]]) -> str:
    return "".join(standing.status[0] for standing, _, _ in told)


def test_lost_after_three_frames_in_a_row() -> None:
    assert statuses(after([0.2, 0.2, 0.3, 0.2, 0.2, 0.2, 0.2])) == "tttttls"
    assert [standing.frames_missed for standing, _, _ in after([0.2, 0.2, 0.3, 0.2])] == [
        1,
        2,
        0,
        1,
    ]


def test_found_after_three_frames_in_a_row_and_learned_from_then_on() -> None:
    told = after([0.5, 0.5, 0.2, 0.5, 0.5, 0.5, 0.5], LOST)
    assert statuses(told) == "ssssstt"
    assert [learned for _, _, learned in told] == [False] * 5 + [True, True]
    assert [there for _, there, _ in told] == [True, True, False, True, True, True, True]
    assert [standing.frames_missed for standing, _, _ in told] == [4, 5, 6, 7, 8, 0, 0]


def test_what_looks_as_it_did_of_late_is_not_lost_but_searched_for() -> None:
    told = after([0.2] * 7, responses=[0.1, 0.1, 0.18, 0.18, 0.1, 0.1, 0.1])
    assert statuses(told) == "ttttttl"
    assert not any(there or learned for _, there, learned in told)
    assert [standing.frames_missed for standing, _, _ in told] == list(range(1, 8))
    assert statuses(after([0.2] * 4, LOST, responses=[0.1, 0.18, 0.18, 0.18])) == "ssst"
    assert statuses(after([0.12] * 4, responses=[0.18] * 4)) == "ttls"
    # Elsewhere, the first look says nothing about what was learned here.
    assert statuses(after([0.2] * 4, LOST, (3,), responses=[0.1, 0.18, 0.18, 0.18])) == "ssss"


def test_who_was_missed_for_long_is_learned_only_after_three_frames_that_agree() -> None:
    """Whatever the status: the response kept it."""
    certainties = [0.2] * 3 + [0.5] * 4
    told = after(certainties, responses=[0.18] * 7)
    assert statuses(told) == "ttttttt"
    assert [learned for _, _, learned in told] == [False] * 5 + [True] * 2
    assert [learned for _, _, learned in after(certainties[1:], responses=[0.18] * 6)] == (
        [False] * 2 + [True] * 4
    )


def test_a_jump_asks_for_more_and_begins_anew_to_count() -> None:
    assert [there for _, there, _ in after([0.3, 0.36], LOST, jumps=(0, 1))] == [False, True]
    assert statuses(after([0.5, 0.5, 0.5, 0.5, 0.5], LOST, jumps=(2,))) == "sssst"


@pytest.mark.parametrize(
    ("certainty", "keeps", "learns"),
    [(0.26, False, False), (0.29, True, False), (0.34, True, True)],
)
def test_it_takes_more_to_learn_than_to_keep(certainty: float, keeps: bool, learns: bool) -> None:
    ((_, there, learned),) = after([certainty])
    assert (there, learned) == (keeps, learns)


def test_a_target_that_is_hard_to_tell_asks_for_a_share_of_its_first_certainty() -> None:
    hard = TargetStatus(reference=0.2, seen=REFERENCE_FRAMES)
    assert [there for _, there, _ in after([0.13, 0.11], hard)] == [True, False]
    lost = hard._replace(status=Status.SEARCHING)
    assert [there for _, there, _ in after([0.15, 0.17], lost, jumps=(0, 1))] == [False, True]


def test_a_lost_target_is_left_where_it_was_if_nothing_there_is_like_it() -> None:
    followed = [ConfidenceGate().may_move(certainty, LOST) for certainty in (0.25, 0.23, 0.21)]
    assert followed == [True, True, False]
    assert ConfidenceGate().may_move(0.0, CLEAR._replace(frames_missed=2))
    assert ConfidenceGate().may_move(0.13, LOST._replace(reference=0.2))


def test_the_reference_is_the_mean_of_the_first_frames() -> None:
    told = after([0.9, 0.7, *[0.8] * (REFERENCE_FRAMES - 2), 0.3, 0.3], TargetStatus())
    assert told[1][0].reference == pytest.approx(0.8)
    assert told[-1][0].reference == pytest.approx(0.8)
    assert told[-1][0].seen == REFERENCE_FRAMES
    assert after([0.1], LOST._replace(seen=2))[0][0].seen == 2  # nothing counts while it is lost
