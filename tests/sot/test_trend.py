"""Reported sizes and turns: they follow steady growth, and start anew where they are rough."""

from __future__ import annotations

import numpy as np
import pytest

from motes.cues.correlation_filter import ScaleFilter
from motes.sot.discriminative.size import Trend


def test_steady_growth_is_followed_without_lag() -> None:
    trend = Trend()
    for frame in range(1, 60):
        trend = trend.measured(0.01 * frame) if frame % 2 else trend.predicted()
    assert trend.value == pytest.approx(0.59, abs=1e-3)
    assert trend.growth == pytest.approx(0.01, abs=1e-3)


def test_noise_at_rest_is_reduced() -> None:
    trend, noise = Trend(), 0.01 * np.random.default_rng(0).standard_normal(400)
    sizes = []
    for value in noise:
        trend = trend.measured(float(value))
        sizes.append(trend.value)
    assert np.std(np.diff(sizes)) < 0.5 * np.std(np.diff(noise))


def test_a_rough_value_is_replaced_by_the_next_measurement() -> None:
    trend = Trend(0.5, rough=True).measured(0.1)
    assert trend == Trend(0.1)


def test_the_maximum_between_sizes() -> None:
    sizes = ScaleFilter(count=5, step=1.1)
    steps = np.linspace(-2, 2, 5)
    assert sizes.between(-((steps - 0.3) ** 2)) == pytest.approx(1.1**0.3)
    assert sizes.between(steps) == pytest.approx(1.1**2)  # nothing beyond the largest
    assert sizes.between(np.zeros(5)) == pytest.approx(1.1**-2)
