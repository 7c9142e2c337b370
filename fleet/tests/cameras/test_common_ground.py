"""The ground that two cameras see: given by a homography, or learned."""

import numpy as np
import pytest

from motes import Box
from motes_fleet.cameras.common_ground import CommonGround
from motes_fleet.cameras.rig_config import Overlap

TILTED = ((0.9, 0.2, -30.0), (-0.1, 1.1, 12.0), (0.0004, 0.0002, 1.0))
GIVEN, LEARNED = Overlap(("a", "b"), TILTED), Overlap(("a", "b"))


ONE, OTHER = Box(0, 0, 20, 40), Box(0, 0, 30, 80)


def learned(count: int, wrong: int = 0) -> CommonGround:
    """Return a ground learned from feet all over a picture, some of them paired wrongly."""
    truth, ground = CommonGround(GIVEN), CommonGround(LEARNED)
    rng = np.random.default_rng(0)
    for n in range(count):
        foot = (float(rng.uniform(0, 200)), float(rng.uniform(0, 150)))
        there = truth.there(foot, 20, "a")
        assert there is not None
        if n < wrong:
            there = there[0] + 90, there[1] - 70
        ground.add((foot, there), ONE, OTHER)
    return ground


@pytest.mark.parametrize("wrong", [0, 30])
def test_a_learned_ground_is_near_the_true_one(wrong: int) -> None:
    truth, ground = CommonGround(GIVEN), learned(300, wrong)
    for point in ((100.0, 80.0), (50.0, 120.0), (150.0, 30.0)):
        there = truth.there(point, 20, "a")
        assert there is not None
        assert ground.there(point, 20, "a") == pytest.approx(there, abs=2.5)
        assert ground.there(there, 30, "b") == pytest.approx(point, abs=2.5)


def test_feet_on_one_line_are_enough_to_stay_on_it() -> None:
    ground = CommonGround(LEARNED)
    for x in range(0, 200, 4):
        ground.add(((x, 50), (x + 7, 61)), ONE, ONE)
    assert ground.there((100, 50), 20, "a") == pytest.approx((107, 61), abs=1)


def test_slopes_are_derivatives() -> None:
    ground = CommonGround(GIVEN)
    slope = ground.slope((100, 80), 20, "a")
    one, other = ground.there((100, 80), 20, "a"), ground.there((101, 82), 20, "a")
    assert slope is not None
    assert one is not None
    assert other is not None
    np.testing.assert_allclose(np.array(other) - one, slope @ [1, 2], rtol=0.01)
    back = ground.slope(one, 20, "b")
    assert back is not None
    np.testing.assert_allclose(slope @ back, np.eye(2), atol=1e-3)
