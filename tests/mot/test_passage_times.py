"""How long objects take through a passage, beside scipy's distributions."""

from __future__ import annotations

import numpy as np
import pytest
from scipy import stats

from motes.mot.cameras.passage_times import PACE, SHORTEST, PassageTimes


def test_before_any_is_learned_all_times_count_the_same() -> None:
    times = PassageTimes(0.0, 60.0)
    assert [times.cost(seconds) for seconds in (0.0, 0.5, 3.0, 60.0)] == [0.0] * 4


def test_the_next_logarithm_has_students_distribution() -> None:
    """Of all learned at once: Murphy 2007, equations 85 to 89 and 104."""
    taken, low, high = np.array([2.0, 2.5, 1.8, 3.1]), np.log(SHORTEST), np.log(60.0)
    times = PassageTimes(0.0, 60.0)
    for seconds in taken:
        times.learn(float(seconds))
    logs, n = np.log(taken), len(taken)
    middle, weight = (low + high) / 2, PACE**2 / ((high - low) ** 2 / 12)
    mean = (weight * middle + logs.sum()) / (weight + n)
    rate = PACE**2 + ((logs - logs.mean()) ** 2).sum() / 2
    rate += weight * n * (logs.mean() - middle) ** 2 / (2 * (weight + n))
    shape = 1 + n / 2
    variance = rate * (weight + n + 1) / (shape * (weight + n))
    after = stats.t(2 * shape, mean, np.sqrt(variance))
    before = stats.t(2, middle, np.sqrt(PACE**2 * (1 + 1 / weight)))
    for seconds in (0.3, 2.4, 9.0, 50.0):
        time = np.log(seconds)
        usual = before.logpdf(time) - before.logpdf(middle)
        cost = usual - (after.logpdf(time) - after.logpdf(mean))
        assert times.cost(seconds) == pytest.approx(max(0.0, cost))
    assert times.cost(2.3) < 0.1 < times.cost(9.0) < times.cost(50.0)


def test_a_narrow_passage_may_be_learned_too() -> None:
    times = PassageTimes(1.0, 1.1)
    times.learn(1.05)
    assert times.cost(1.05) < 0.1
