"""The turns and sizes that the default tracker reports: neither steps, nor lag, nor jitter."""

import math

import numpy as np
import pytest

from motes import Ellipse, Frame, Tracker
from motes.core.types import Floats
from motes.cues.correlation_filter import ScaleFilter
from motes.sot.discriminative.size import POINTS, Trend, TurnEstimate, sampled
from motes.synthetic.clips import still, turning


def wrapped(angles: Floats) -> Floats:
    """Return angles from -90 to 90 degrees, in degrees."""
    out: Floats = np.degrees(np.mod(angles + math.pi / 2, math.pi) - math.pi / 2)
    return out


@pytest.mark.slow
def test_a_turn_is_followed_without_steps() -> None:
    clip, tracker = turning((160, 120)), Tracker()
    found, truth = list[float](), list[float]()
    for index in range(10, 70):  # in frame 0 it is upright
        frame, (true, *_) = clip[index]
        track = tracker.update(frame) if found else tracker.init(frame, true.ellipse)
        found.append(track.ellipse.theta)
        truth.append(true.ellipse.theta)
    assert np.ptp(np.unwrap(truth, period=math.pi)) > 2  # radians
    assert np.abs(wrapped(np.subtract(found, truth))).max() < 8
    steps = np.diff(np.unwrap(found, period=math.pi))
    assert np.degrees(np.abs(steps)).max() < 9  # one of 3.6 degrees each; a window's is of 14


def test_a_turned_picture_is_turned_by_as_much() -> None:
    y, x = np.mgrid[:101, :101] - 50
    for angle in (-0.6, 0.1, 0.7):
        pixels = []
        for turn in (0.0, angle):
            around = np.arctan2(y, x) - turn
            gray = 128 + 60 * np.cos(around) + 50 * np.sin(2 * around + 1)
            pixels.append(np.repeat(gray[..., None], 3, axis=2).astype(np.uint8))
        region = Ellipse(50, 50, 30, 20, 0.3)
        first, second = (Frame(i, i / 25, each) for i, each in enumerate(pixels))
        assert sampled(first, region).shape == (24, POINTS)
        estimate = TurnEstimate.begin(first, region)
        for _ in range(12):
            estimate = estimate.followed(second, region, 0.0, 0.0, seen=True)
        assert estimate.angle.value == pytest.approx(angle, abs=0.01)


@pytest.mark.slow
def test_jitter_at_rest() -> None:
    """A target at rest under noise jitters by less than 0.3 pixels."""
    frame, (true, *_) = still((160, 120), target=(30, 40), frames=1)[0]
    rng, tracker, found = np.random.default_rng(0), Tracker(), list[Ellipse]()
    for index in range(40):
        noisy = np.clip(frame.pixels + rng.normal(0, 8, frame.pixels.shape), 0, 255)
        seen = Frame(index, index / 25, noisy.astype(np.uint8))
        track = tracker.update(seen) if index else tracker.init(seen, true.ellipse.box)
        found.append(track.ellipse)
    x, y, a, b, _ = np.std(found, axis=0)
    assert max(x, y, a, b) < 0.3
    assert np.abs(np.subtract(found, found[0])[:, :2]).max() < 0.5


def test_steady_growth_is_followed_without_lag() -> None:
    trend = Trend()
    for frame in range(1, 60):
        trend = trend.measured(0.01 * frame) if frame % 2 else trend.predicted()
    assert trend.value == pytest.approx(0.59, abs=1e-3)
    assert trend.growth == pytest.approx(0.01, abs=1e-3)


def test_a_rough_value_is_replaced_by_the_next_measurement() -> None:
    trend = Trend(0.5, rough=True).measured(0.1)
    assert trend == Trend(0.1)


def test_the_maximum_between_sizes() -> None:
    sizes = ScaleFilter(count=5, step=1.1)
    steps = np.linspace(-2, 2, 5)
    assert sizes.between(-((steps - 0.3) ** 2)) == pytest.approx(1.1**0.3)
    assert sizes.between(steps) == pytest.approx(1.1**2)  # nothing beyond the largest
    assert sizes.between(np.zeros(5)) == pytest.approx(1.1**-2)
