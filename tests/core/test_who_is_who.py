"""Who is who: the likeliest assignment of all at once, and how certain it is."""

import itertools
import math

import numpy as np
import pytest

from motes.core import who_is_who as module
from motes.core.who_is_who import who_is_who

NEVER = math.inf


@pytest.mark.parametrize(
    ("costs", "models", "certainty"),
    [
        ([[0.0, math.log(3)], [0.0, 0.0]], [0, 1], [0.75, 0.75]),  # odds of 3 to 1
        ([[1.0, 1.0], [1.0, 1.0]], None, [0.5, 0.5]),  # nothing tells
        # Three in a circle: each pair alone would rather stay.
        ([[2.0, 0.0, 9.0], [9.0, 2.0, 0.0], [0.0, 9.0, 2.0]], [1, 2, 0], None),
        # Somebody hidden is a column more; the first track is that one, and 0 is hidden.
        ([[4.0, 5.0, 0.0], [5.0, 0.0, 5.0]], [2, 1], None),
        # Nobody known: a column of its own for each track.
        ([[9.0, 8.0, 5.0, NEVER], [0.0, 9.0, NEVER, 5.0]], [2, 0], None),
    ],
)
def test_the_least_sum_of_costs_is_who_is_who(
    costs: list[list[float]], models: list[int] | None, certainty: list[float] | None
) -> None:
    found, sure = who_is_who(np.array(costs))
    assert models is None or found.tolist() == models
    assert sure == pytest.approx(certainty if certainty else sure)
    assert ((sure > 0) & (sure <= 1)).all()


def test_many_are_assigned_as_few_are(monkeypatch: pytest.MonkeyPatch) -> None:
    rng = np.random.default_rng(0)
    costs = rng.uniform(0, 8, (4, 6))
    exact, certainty = who_is_who(costs)
    sums = {each: costs[range(4), each].sum() for each in itertools.permutations(range(6), 4)}
    assert tuple(exact) == min(sums, key=sums.__getitem__)
    odds = {each: math.exp(-cost) for each, cost in sums.items()}
    first = sum(value for each, value in odds.items() if each[0] == exact[0])
    assert certainty[0] == pytest.approx(first / sum(odds.values()))
    monkeypatch.setattr(module, "FEW", 0)
    near, rough = who_is_who(costs)
    assert near.tolist() == exact.tolist()
    assert rough == pytest.approx(certainty, abs=0.1)
