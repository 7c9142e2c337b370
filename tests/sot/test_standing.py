"""Being lost and found again by evidence alone, and two places until the evidence decides."""

import pytest

from motes import Ellipse, Status
from motes.sot.discriminative.rival import APART, DECIDED, Rival, apart
from motes.sot.discriminative.standing import FRAMES, Standing

TRACKED = Standing()
LOST = Standing(status=Status.LOST, missed=FRAMES)


@pytest.mark.parametrize(
    ("before", "evidence", "jumps", "statuses", "missed"),
    [
        # Lost after three frames in a row; one bad frame is forgiven at once.
        (TRACKED, [-1, -1, 1, -1, -1, -1, -1], (), "tttttls", [1, 2, 0, 1, 2, 3, 4]),
        # Found after three frames in a row, and believed from then on.
        (LOST, [1, 1, -1, 1, 1, 1, 1], (), "ssssstt", [4, 5, 6, 7, 8, 0, 0]),
        # A jump begins anew to count, but in a frame that was missed only now.
        (LOST, [1, 1, 1, 1, 1], (2,), "sssst", [4, 5, 6, 7, 0]),
        (TRACKED, [1.5], (0,), "t", [0]),
        # The threshold is where the target is as likely there as not.
        (TRACKED, [0.01, 0.0], (), "tt", [0, 1]),
    ],
)
def test_lost_and_found(
    before: Standing,
    evidence: list[float],
    jumps: tuple[int, ...],
    statuses: str,
    missed: list[int],
) -> None:
    told, standing = [], before
    for index, log_odds in enumerate(evidence):
        standing = standing.after(log_odds, jumped=index in jumps)
        told.append(standing)
    assert "".join(each.status[0] for each in told) == statuses
    assert [each.missed for each in told] == missed


HERE = Ellipse(50.0, 50.0, 10.0, 10.0, 0.0)
THERE = HERE._replace(x=90.0)


@pytest.mark.parametrize("sign", [1, -1])
@pytest.mark.parametrize(
    ("differences", "decided"),
    [
        ([0.0], False),
        ([0.4] * 2, False),
        ([0.4] * 3, True),  # small differences add up
        ([1.01 * DECIDED], True),
        ([0.8, -0.8] * 20, False),
    ],
)
def test_evidence_decides_between_rivals(
    differences: list[float], decided: bool, sign: int
) -> None:
    rival = Rival(HERE)
    assert not rival.alive
    for difference in differences:
        rival = rival.after(THERE, sign * difference)
    assert rival.alive
    assert rival.place == THERE
    assert (rival.wins, rival.loses) == (decided and sign > 0, decided and sign < 0)


def test_places_part_by_their_distance_in_sides_of_the_target() -> None:
    for sides, parted in ((0.99, False), (1.01, True)):
        other = HERE._replace(x=50.0 + sides * APART * HERE.side)
        assert apart(other, HERE) is parted
