"""The smoother: against the textbook, over gaps, with outliers; the support of two passes."""

import numpy as np
import pytest

from motes import Ellipse, Status
from motes.core.types import Floats
from motes.correction import Coordinates, Course, doubts, join
from motes.correction.smoothing import Drift, Dynamics, fit_motion, outliers, smoothed
from motes.correction.support import support


def ones(count: int) -> Floats:
    return np.ones((count, 1))


def test_it_is_the_posterior_of_all_observations() -> None:
    """A random walk with one observation a frame: the joint Gaussian gives the same answer."""
    rng = np.random.default_rng(0)
    n, q, r = 12, 0.5, 0.8
    seen = rng.normal(0, 2, (n, 1))
    valid = np.ones(n, bool)
    valid[[4, 5, 9]] = False
    motion = Dynamics(np.zeros(1), np.array([q]), np.array([r]))
    path = smoothed(seen[None], valid[None], ones(n)[None], {}, motion, None)
    steps = np.diff(np.eye(n), axis=0)
    precision = steps.T @ steps / q + np.diag(valid / r)
    covariance = np.linalg.inv(precision)
    mean = covariance @ (np.where(valid, seen[:, 0], 0) / r)
    assert path.mean[:, 0] == pytest.approx(mean, abs=1e-4)
    assert path.variance[:, 0] == pytest.approx(covariance.diagonal(), rel=1e-3)


def test_the_pass_that_is_nearer_to_its_keyframe_counts_more() -> None:
    """Both drift; the keyframe at the far end of each shows how far."""
    n = 41
    t = np.arange(n)
    forward, backward = 0.02 * t, -0.02 * (n - 1 - t)
    passes = np.stack([forward, backward])[:, :, None]
    relative = np.ones((2, n, 1))
    relative[0, 0] = relative[1, -1] = 0
    exact = {0: np.zeros(1), n - 1: np.zeros(1)}
    motion = Dynamics(np.zeros(1), np.array([0.1]), np.array([1e-3]))
    drift = Drift(np.array([0.3]), np.array([50.0]))
    path = smoothed(passes, np.ones((2, n), bool), relative, exact, motion, drift)
    assert np.abs(path.mean).max() < 0.1  # half of it would be 0.4
    assert path.mean[5, 0] == pytest.approx(0, abs=0.05)


def test_the_motion_is_found_again() -> None:
    rng = np.random.default_rng(1)
    walk = np.cumsum(rng.normal(0, 1, (2000, 1)), axis=0)
    valid = np.ones(2000, bool)
    noisy = fit_motion(walk + rng.normal(0, 3, (2000, 1)), valid, ones(2000))
    clean = fit_motion(walk, valid, ones(2000))
    assert clean.persistence[0] == 0
    assert clean.acceleration[0] == pytest.approx(1, rel=0.2)
    assert noisy.noise[0] == pytest.approx(9, rel=0.3)
    glide = np.cumsum(np.cumsum(rng.normal(0, 0.1, (500, 1)), axis=0), axis=0)
    assert fit_motion(glide, np.ones(500, bool), ones(500)).persistence[0] == 0.95


def test_jumps_away_and_back_are_outliers() -> None:
    rng = np.random.default_rng(2)
    seen = np.cumsum(rng.normal(0, 0.1, (60, 2)), axis=0)
    valid = np.ones(60, bool)
    assert not outliers(seen, valid, 13.82).any()
    seen[30:34] += 20
    assert np.flatnonzero(outliers(seen, valid, 13.82)).tolist() == [30, 31, 32, 33]
    seen[30:] += 20  # it stays there: both places are explained, one by the future
    seen[30:34] -= 20
    assert not outliers(seen, valid, 13.82).any()


def test_a_target_that_rests_and_runs_does_not_jump() -> None:
    rng = np.random.default_rng(2)
    rest, run = np.zeros(30), np.full(5, 4.0)
    steps = np.concatenate([rest, run, rest, run, rest, -run, rest])
    seen = np.cumsum(steps)[:, None] + rng.normal(0, 0.1, (len(steps), 2))
    valid = np.ones(len(seen), bool)
    assert not outliers(seen, valid, 13.82).any()
    seen[50:53] += 9
    assert np.flatnonzero(outliers(seen, valid, 13.82)).tolist() == [50, 51, 52]


def test_one_pass_that_leaves_the_target_is_left_out() -> None:
    n = 40
    agree = np.ones(n, bool)
    confidence = np.full((2, n), 0.8)
    nowhere = np.zeros(n, bool)
    both = support(confidence, agree, (True, True), nowhere)
    assert both.used.all()
    agree[25:] = False
    confidence[0, 25:] = 0.2
    follows = support(confidence, agree, (False, True), nowhere)
    assert follows.used[0, :24].all()
    assert not follows.used[0, 26:].any()
    assert follows.used[1].all()
    assert follows.probability.min() > 0.5


def test_where_both_are_lost_or_the_target_is_absent_nothing_is_used() -> None:
    agree, absent = np.zeros(60, bool), np.zeros(60, bool)
    agree[:10] = agree[-10:] = absent[2:5] = True
    confidence = np.full((2, 60), 0.9)
    confidence[:, 10:-10] = 0.02
    follows = support(confidence, agree, (True, True), absent)
    assert follows.used[:, 5:9].all()
    assert not follows.used[:, absent].any()
    assert not follows.used[:, 25:35].any()


def test_frames_between_two_supports_are_bridged_where_nothing_was_absent() -> None:
    rng = np.random.default_rng(0)
    for _ in range(50):
        supported, absent = rng.random((2, 12)) < ((0.3,), (0.1,))
        found = join._bridged(supported, absent & ~supported)
        for frame in range(12):
            before = [other for other in range(frame) if supported[other]]
            after = [other for other in range(frame + 1, 12) if supported[other]]
            between = before and after and not (absent & ~supported)[before[-1] : after[0]].any()
            assert found[frame] == (not supported[frame] and bool(between))


@pytest.mark.parametrize("theta", [0.0, 0.4])
def test_variances_are_compared_in_the_units_of_each_region(theta: float) -> None:
    """Half the region with a quarter of the variances is as sure; so is each coordinate."""
    rows = np.array([[50, 40, 16, 8, theta]] * 3 + [[50, 40, 8, 4, theta]] * 2)
    variances = np.array([[4, 4, 2, 2, 0.1]] * 3 + [[4, 4, 0.5, 0.5, 0.1]] * 2)
    space = Coordinates.of([Ellipse(*row) for row in rows.tolist()], rows)
    assert space.relative(rows, variances) == pytest.approx(np.ones((5, 5 if theta else 4)))
    variances[4, 2:] *= 3
    assert space.relative(rows, variances)[4] == pytest.approx([1, 1, 3, 3, 3][: space.dimensions])


def test_how_far_a_target_drifts_goes_by_its_size() -> None:
    keys = np.array([True, False, False, False])
    small = np.array([[50, 40, 9, 4, 0.3]] * 4)

    def drifted(times: float) -> Floats:
        ellipses = small * [1, 1, times, times, 1]
        course = Course(ellipses, ellipses, np.ones(4), [Status.TRACKING] * 4, ~keys)
        return doubts._drifted(course, keys)

    assert (np.diff(drifted(1.0), axis=0) > 0).all()
    assert drifted(3.0) == pytest.approx(drifted(1.0) * [9, 9, 9, 9, 1])
