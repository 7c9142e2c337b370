"""Metrics against hand-worked examples and slow second implementations."""

import itertools
import math

import numpy as np
import pytest
from hypothesis import given, strategies as st

from motes import Ellipse
from motes_lab.metrics import sot as metrics
from motes_lab.metrics.statistics import paired_difference, wilson_interval

shares = st.floats(0, 1)
# Recovery and coverage


def recoveries(overlaps: list[float]) -> tuple[int, int]:
    """Return what becomes of overlaps, NaN for no target."""
    table = np.array(overlaps)
    return metrics.recoveries(np.isfinite(table), ~(table >= 0.1), table > 0.5)


NO = math.nan


@given(st.lists(st.tuples(st.sampled_from([0.0, 0.3, 0.9, NO]), st.integers(1, 40)), max_size=8))
def test_recoveries_frame_by_frame(runs: list[tuple[float, int]]) -> None:
    overlaps = [value for value, count in runs for _ in range(count)]
    counted = found = 0
    had = False
    for i, value in enumerate(overlaps):
        if value != value:
            continue
        if value < 0.1 and had:
            later = "".join("x" if other == other else "-" for other in overlaps[i:])
            counted += "x" * 30 in later
            found += "x" * 30 in later and any(other > 0.5 for other in overlaps[i:])
        had = value >= 0.1
    assert recoveries(overlaps) == (counted, found)


def test_coverage_by_hand() -> None:
    """The ellipse of variances 4 and 1 has half-axes 2 and 1, times the root of 5.991: 2.4477."""
    square = (4.0, 0.0, 1.0)
    turned = (2.5, 1.5, 2.5)  # the same, turned by 45 degrees
    cases = [
        ((4.89, 0), square, True),
        ((4.90, 0), square, False),
        ((0, -2.44), square, True),
        ((0, 2.45), square, False),
        ((3.45, 3.45), turned, True),
        ((3.47, 3.47), turned, False),
        ((1.72, -1.72), turned, True),
        ((1.74, -1.74), turned, False),
        ((0, 0), (0.0, 0.0, 0.0), False),
        ((0, 0), (1.0, 1.0, 1.0), False),
        ((0, 0), (NO, NO, NO), False),
    ]
    offsets, covariances, inside = zip(*cases, strict=True)
    found = metrics.covered(np.array(offsets, float), np.array(covariances))
    assert found.tolist() == list(inside)


@given(st.lists(shares, min_size=1, max_size=20))
def test_success_as_in_the_benchmark(overlaps: list[float]) -> None:
    """The benchmark's own program counts frames threshold by threshold."""
    curve = []
    for step in range(21):
        count = 0
        for overlap in overlaps:
            count += overlap > metrics.THRESHOLDS[step]
        curve.append(count / len(overlaps))
    assert metrics.success_curve(np.array(overlaps)) == pytest.approx(np.array(curve))
    assert metrics.success_auc(np.array(overlaps)) == pytest.approx(sum(curve) / 21)
    assert curve == sorted(curve, reverse=True)
    # The curve's area is the mean overlap, but for the width of a step.
    assert abs(sum(curve) / 21 - sum(overlaps) / len(overlaps)) <= 1 / 20


def raster_od(one: Ellipse, other: Ellipse, size: int = 800) -> float:
    """Count the pixels of both ellipses on a fine grid over them."""
    boxes = np.array([one.box, other.box])
    low = boxes[:, :2].min(axis=0) - 1
    high = (boxes[:, :2] + boxes[:, 2:]).max(axis=0) + 1
    x, y = np.meshgrid(*np.linspace(low, high, size).T)
    inside = []
    for center_x, center_y, a, b, theta in (one, other):
        along = (x - center_x) * math.cos(theta) + (y - center_y) * math.sin(theta)
        across = (y - center_y) * math.cos(theta) - (x - center_x) * math.sin(theta)
        inside.append((along / a) ** 2 + (across / b) ** 2 <= 1)
    together = np.count_nonzero(inside[0]) + np.count_nonzero(inside[1])
    return 1 - 2 * np.count_nonzero(inside[0] & inside[1]) / together


@pytest.mark.slow
def test_od_against_a_pixel_count() -> None:
    rng = np.random.default_rng(4)
    truths = np.column_stack(
        [rng.uniform(0, 99, (20, 2)), rng.uniform(4, 60, (20, 2)), rng.uniform(-3, 3, 20)]
    )
    noise = rng.normal(0, 1, (20, 5)) * (15, 15, 0.3, 0.3, 0.5)
    ellipses = np.column_stack(
        [truths[:, :2] + noise[:, :2], truths[:, 2:4] * np.exp(noise[:, 2:4]), noise[:, 4]]
    )
    found = metrics.overlap_distances(ellipses, truths)
    counted = [raster_od(Ellipse(*p), Ellipse(*q)) for p, q in zip(ellipses, truths, strict=True)]
    assert 0.05 < min(counted) < max(counted) < 1
    assert found == pytest.approx(np.array(counted), abs=0.01)


def test_od_of_what_is_no_ellipse() -> None:
    good, nan = [5, 5, 4, 2, 0], [np.nan] * 5
    rows = np.array([nan, [5, 5, 0, 2, 0], [5, 5, np.inf, 2, 0], good, nan])
    truths = np.array([good, good, good, nan, nan])
    assert np.array_equal(
        metrics.overlap_distances(rows, truths), [1, 1, 1, np.nan, np.nan], equal_nan=True
    )
    assert metrics.overlap_distances(np.empty((0, 5)), np.empty((0, 5))).shape == (0,)


@given(st.lists(st.tuples(shares, st.booleans(), st.floats(0.01, 9)), min_size=1, max_size=40))
def test_calibration_bin_by_bin(rows: list[tuple[float, bool, float]]) -> None:
    error, total = 0.0, sum(weight for *_, weight in rows)
    for k in range(10):
        inside = [row for row in rows if min(int(row[0] * 10), 9) == k]
        if weight := sum(w for *_, w in inside):
            said = sum(c * w for c, _, w in inside) / weight
            right = sum(w for _, correct, w in inside if correct) / weight
            error += weight / total * abs(said - right)
    confidence, correct, weights = (np.array(column) for column in zip(*rows, strict=True))
    found = metrics.calibration_error(confidence, correct, weights)
    assert found == pytest.approx(error, abs=1e-12)
    assert 0 <= found <= 1 + 1e-12
    assert math.isnan(metrics.calibration_error(np.zeros(0), np.zeros(0, bool), np.zeros(0)))


def test_difference_of_two_pairs() -> None:
    """Means of two draws are 0.1 or 0.3 with probability 1/4 each, so the interval is both."""
    found = paired_difference(np.array([0.5, 0.7]), np.array([0.4, 0.4]))
    assert found == pytest.approx((0.2, 0.1, 0.3))


def test_difference_against_all_resamples() -> None:
    differences = [0.1, -0.05, 0.3, 0.02, 0.11]
    means = sorted(sum(draw) / 5 for draw in itertools.product(differences, repeat=5))
    at = [means[round(share * len(means))] for share in (0.02, 0.03, 0.97, 0.98)]
    found = paired_difference(np.array(differences), np.zeros(5))
    assert found.mean == pytest.approx(sum(differences) / 5)
    assert at[0] - 1e-9 <= found.low <= at[1] + 1e-9
    assert at[2] - 1e-9 <= found.high <= at[3] + 1e-9


@given(st.lists(st.tuples(shares, shares), min_size=2, max_size=12))
def test_difference_properties(pairs: list[tuple[float, float]]) -> None:
    ours, theirs = np.array(pairs).T
    found = paired_difference(ours, theirs)
    tiny = 1e-12
    assert (ours - theirs).min() - tiny <= found.low <= found.high <= (ours - theirs).max() + tiny
    assert found == paired_difference(ours, theirs)
    mirrored = paired_difference(theirs, ours)
    assert (-mirrored.mean, -mirrored.high, -mirrored.low) == pytest.approx(found, abs=1e-9)


def test_wilsons_interval() -> None:
    assert wilson_interval(10, 10) == pytest.approx((0.7225, 1), abs=1e-4)
    assert wilson_interval(0, 10) == pytest.approx((0, 0.2775), abs=1e-4)
    assert wilson_interval(5, 10) == pytest.approx((0.2366, 0.7634), abs=1e-4)
