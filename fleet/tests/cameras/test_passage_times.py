"""How long objects take through a passage, beside scipy's distributions."""

from __future__ import annotations

import numpy as np
import pytest
from scipy import stats

from motes_fleet.cameras.passage_times import PACE, SHORTEST, PassageTimes


def test_the_next_logarithm_has_students_distribution() -> None:
    """Of all learned at once: Murphy 2007, equations 85 to 89 and 104."""
    taken, times = np.array([2.0, 2.5, 1.8, 3.1]), PassageTimes()
    for seconds in taken:
        times.learn(float(seconds))
    logs, n = np.log(taken), len(taken)
    shape, rate = 1 + n / 2, PACE**2 + ((logs - logs.mean()) ** 2).sum() / 2
    after = stats.t(2 * shape, logs.mean(), np.sqrt(rate / shape * (n + 1) / n))
    for seconds in (0.3, 2.4, 9.0, 50.0):
        cost = after.logpdf(logs.mean()) - after.logpdf(np.log(seconds))
        assert times.cost(seconds) == pytest.approx(cost)
    assert times.cost(0.0) == times.cost(SHORTEST)
    assert times.cost(2.3) < 0.1 < times.cost(9.0) < times.cost(50.0)
