"""The protocol of algorithms: what each of them keeps and reports."""

from typing import Any

import numpy as np
import pytest

from motes import Algorithm, configure, preset
from oracles import region, scene

NAMES = ("default", "nummiaro", "maggio", "mean_shift")


def algorithm(name: str) -> Algorithm[Any]:
    return configure(
        preset(name), {"presence": {"max_positions": 100}} if name != "default" else {}
    )


@pytest.mark.parametrize("name", NAMES)
def test_an_algorithm_keeps_the_state_that_it_names(name: str) -> None:
    each, rng = algorithm(name), np.random.default_rng(0)
    first, last = scene(0, (30.0, 36)), scene(1, (32.0, 36))
    state, info = each.init(rng, first, region((30.0, 36)))
    assert type(state) is each.state_type
    for after, report in (
        each.step(rng, state, last),
        each.correct(state, first, region((32.0, 36))),
    ):
        assert type(after) is each.state_type
        assert type(report) is type(info)
        each.typed(after, first if report.track.frame == 0 else last)


@pytest.mark.parametrize("name", NAMES)
def test_a_step_changes_nothing_that_it_is_given(name: str) -> None:
    each, picture = algorithm(name), scene(1, (32.0, 36))
    state, _ = each.init(np.random.default_rng(0), scene(0, (30.0, 36)), region((30.0, 36)))
    one, other = (each.step(np.random.default_rng(1), state, picture)[1] for _ in "12")
    assert one.track.ellipse == other.track.ellipse
    np.testing.assert_array_equal(one.ellipses, other.ellipses)
