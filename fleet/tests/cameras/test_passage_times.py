"""How long objects take through a passage, beside the density of Student's distribution."""

import numpy as np
import pytest

from motes_fleet.cameras.passage_times import PACE, SHORTEST, PassageTimes


def test_the_next_logarithm_has_students_distribution() -> None:
    """Of all learned at once: Murphy 2007, equations 85 to 89 and 104."""
    taken, times = np.array([2.0, 2.5, 1.8, 3.1]), PassageTimes()
    for seconds in taken:
        times.learn(float(seconds))
    logs, n = np.log(taken), len(taken)
    shape, rate = 1 + n / 2, PACE**2 + ((logs - logs.mean()) ** 2).sum() / 2
    freedom, variance = 2 * shape, rate / shape * (n + 1) / n
    for seconds in (0.3, 2.4, 9.0, 50.0):
        off = (np.log(seconds) - logs.mean()) ** 2 / variance
        cost = (freedom + 1) / 2 * np.log1p(off / freedom)  # of log densities, from the top
        assert times.cost(seconds) == pytest.approx(cost)
    assert times.cost(0.0) == times.cost(SHORTEST)
    assert times.cost(2.3) < 0.1 < times.cost(9.0) < times.cost(50.0)
