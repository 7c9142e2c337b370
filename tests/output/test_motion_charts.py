"""The figures of a target's course show all of it."""

import numpy as np
import pytest

from motes.output.motion_charts import NARROWEST, MotionSeries, path


def course(along: np.ndarray, still: np.ndarray) -> MotionSeries:
    std = np.full(50, 0.01)
    return MotionSeries(along, along, still, std, std, still, std, still, still, std, std)


@pytest.mark.slow
@pytest.mark.parametrize("turned", [False, True])
def test_a_straight_path_has_room_beside_it(turned: bool) -> None:
    along, still = np.linspace(0, 6, 50), np.full(50, 2.4)
    x, y = (still, along) if turned else (along, still)
    (axes,) = path(course(along, still)._replace(x=x, y=y), "m").axes
    spans = [float(np.ptp(limits)) for limits in (axes.get_xlim(), axes.get_ylim())]
    assert min(spans) == pytest.approx(NARROWEST * max(spans))
    assert np.mean(axes.get_xlim()) == pytest.approx(x.mean())
    assert np.mean(axes.get_ylim()) == pytest.approx(y.mean())
