"""How many particles there are, by the spread of the target's whereabouts."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from msgspec.structs import replace

from motes import ConfigError, Tracker, preset, synthetic
from motes.core.geometry import Ellipse
from motes.sot.filtering.resampling import KldSampling
from motes.sot.particle_filter import ParticleFilter

FIRST = Ellipse(50, 50, 10, 40)  # a mean half-axis of 20
WIDE = KldSampling(min=1, max=10**6, error=0.1, bin=1.0)
CLIP = [frame for frame, _ in synthetic.still((160, 120), target=(30, 40), frames=12)]
REGION = synthetic.still((160, 120), target=(30, 40), frames=1)[0][1][0].ellipse


def apart(k: int) -> Any:
    """Return ellipses in k bins, three in each."""
    ellipses = np.tile(np.array(FIRST), (3 * k, 1))
    ellipses[:, 0] = 20.0 * np.repeat(np.arange(k), 3) + 5
    return ellipses


@pytest.mark.parametrize(
    ("k", "quantile"), [(2, 6.635), (11, 23.209), (51, 76.154), (101, 135.807)]
)
def test_the_number_is_that_of_the_chi_square_test(k: int, quantile: float) -> None:
    """Fox's equation 7 stands for the 99 % quantile of k - 1 degrees of freedom over 2 epsilon."""
    expected = quantile / (2 * 0.1)
    assert WIDE.count(apart(k), FIRST) == pytest.approx(expected, rel=0.02, abs=1)


def test_bins_are_in_units_of_the_target() -> None:
    """Twice the target in twice the picture needs the same number; steps of e in size are bins."""
    ellipses = apart(9)
    twice = ellipses * [2, 2, 2, 2, 1]
    double = Ellipse(100, 100, 20, 80)
    assert WIDE.count(twice, double) == WIDE.count(ellipses, FIRST)
    assert WIDE.count(ellipses, double) < WIDE.count(ellipses, FIRST)
    sizes = np.tile(np.array(FIRST), (4, 1))
    sizes[:, 2:4] *= np.array([1, math.e, math.e**2, math.e**3])[:, None]
    assert WIDE.count(sizes, FIRST) == WIDE.count(apart(4), FIRST)


def test_a_range_upside_down() -> None:
    with pytest.raises(ConfigError, match="min is 60, and max is 50; make min smaller"):
        KldSampling(min=60, max=50)


def numbers(config: ParticleFilter) -> list[int]:
    """Return how many particles each frame after the first had."""
    tracker = Tracker(config)
    tracker.init(CLIP[0], REGION)
    found = []
    for frame in CLIP[1:]:
        track = tracker.update(frame)
        info = tracker.info
        assert len(info.weights) == len(info.ellipses)
        assert info.weights.sum() == pytest.approx(1)
        assert track.effective_sample_size <= len(info.weights) + 1e-9
        found.append(len(info.weights))
    return found


def config(name: str = "nummiaro", **changes: Any) -> ParticleFilter:
    base = preset(name)
    assert isinstance(base, ParticleFilter)
    return replace(base, **changes)


@pytest.mark.parametrize("name", ["nummiaro", "maggio"])
def test_a_filter_with_a_budget_follows_its_spread(name: str) -> None:
    chosen = numbers(config(name, budget=KldSampling(min=20, max=300)))
    assert len(set(chosen)) > 3
    assert all(20 <= n <= 300 for n in chosen)
    assert numbers(config(name)) == [config(name).particles] * 11


def test_the_first_frame_is_within_the_budget() -> None:
    for least, most, first in ((300, 500, 300), (10, 40, 40), (50, 500, 100)):
        tracker = Tracker(config(budget=KldSampling(min=least, max=most)))
        tracker.init(CLIP[0], REGION)
        assert len(tracker.info.weights) == first
