"""Motion models: one suite for all, and each against its closed form (equations 8 and 9)."""

import math

import msgspec
import numpy as np
import pytest
from hypothesis import given, strategies as st

from motes.core import FRAME_INTERVAL, Floats
from motes.core.geometry import Ellipse
from motes.sot.filtering.motion import (
    Autoregressive,
    ConstantVelocity,
    EllipseWalk,
    Motion,
    Noise,
    RandomWalk,
    SecondOrder,
)

# Without what is not linear: a common change of size is tested by itself.
NOISE = Noise(position=0.3, size=0, size_return=0, aspect=0.05, angle=0.2)
FIRST = Ellipse(500, 400, 60, 25, 0.1)
Linear = RandomWalk | ConstantVelocity | SecondOrder
MODELS: list[Linear] = [
    RandomWalk(noise=NOISE),
    ConstantVelocity(noise=NOISE),
    ConstantVelocity(noise=NOISE, velocity=0.8, persistence=0.5),
    ConstantVelocity(noise=NOISE, persistence=0.0),
    SecondOrder(noise=NOISE, persistence=0.7),
]
model_ = pytest.mark.parametrize("model", MODELS)
"""Those that are linear, with noise proportional to the first region."""


def moving(model: Motion, n: int) -> Floats:
    """Return n equal states that move, grow and accelerate where the model can."""
    states = model.initial(np.tile(np.array(FIRST), (n, 1)))
    if isinstance(model, Autoregressive):
        states[:, 3:6] -= [7.0, -4.0, 0.01]
        return states
    pattern = np.array([7.0, -4.0, 1.5, 0.5, 1.0, -2.0, 0.25, 0.125])
    states[:, 5:] = pattern[: states.shape[1] - 5]
    return states


def matrices(model: Linear, steps: float) -> tuple[Floats, Floats]:
    """Return A and the covariance of w, written down as block matrices."""
    grown = NOISE.position * math.sqrt(steps), NOISE.aspect * math.sqrt(steps)
    mean = math.sqrt(60 * 25)
    base = np.array(
        [mean * grown[0], mean * grown[0], 60 * grown[1], 25 * grown[1], 0.2 * math.sqrt(steps)]
    )
    if isinstance(model, RandomWalk):
        return np.eye(5), np.diag(base**2)
    kept = model.persistence**steps
    eye, zero = np.eye(4), np.zeros((4, 4))
    if not isinstance(model, SecondOrder):
        # Position takes the new velocity, and so its noise too.
        step = np.block([[eye, steps * eye], [zero, eye]])
        a = step @ np.block([[eye, zero], [zero, kept * eye]])
        sources = np.concatenate([base[:4], model.velocity * base[:4]])
    else:
        move = np.block([[eye, steps * eye, zero], [zero, eye, zero], [zero, zero, eye]])
        speed = np.block([[eye, zero, zero], [zero, eye, steps * eye], [zero, zero, eye]])
        step = move @ speed
        a = step @ np.diag(np.repeat([1, kept, kept], 4))
        sources = np.concatenate(
            [base[:4], model.velocity * base[:4], model.acceleration * base[:4]]
        )
    q = step @ np.diag(sources**2) @ step.T
    # The angle is column 4, between the sizes and the velocities.
    order = [0, 1, 2, 3, len(a), *range(4, len(a))]
    pad = np.zeros((len(a), 1))
    a = np.block([[a, pad], [pad.T, np.eye(1)]])
    q = np.block([[q, pad], [pad.T, base[4:][None] ** 2]])
    return a[np.ix_(order, order)], q[np.ix_(order, order)]


@model_
@pytest.mark.parametrize("frames", [0.25, 1.0, 3.0])
def test_mean_and_covariance(model: Linear, frames: float) -> None:
    n = 60_000
    states = moving(model, n)
    out = model.propagate(np.random.default_rng(4), states, frames * FRAME_INTERVAL, FIRST)
    a, q = matrices(model, frames)
    deviations = np.sqrt(np.diag(q))
    error = np.abs(out.mean(axis=0) - a @ states[0])
    assert (error <= 4.5 * deviations / math.sqrt(n)).all()
    correlation = np.cov(out.T) / np.outer(deviations, deviations)
    np.testing.assert_allclose(correlation, q / np.outer(deviations, deviations), atol=0.025)


@model_
@pytest.mark.parametrize("frames", [0.5, 1.0, 4.0])
def test_both_half_axes_grow_and_return_together(model: Linear, frames: float) -> None:
    """In logarithms: a share of the way back to the first size, and one noise for both."""
    noise = Noise(position=0, size=0.1, size_return=0.2, aspect=0)
    model = msgspec.structs.replace(model, noise=noise)
    n = 20_000
    states = model.initial(np.tile([0.0, 0, 120, 20, 0], (n, 1)))
    out = model.propagate(np.random.default_rng(3), states, frames * FRAME_INTERVAL, FIRST)
    logs = np.log(out[:, 2:4] / [FIRST.a, FIRST.b])
    expected = 0.8**frames * np.log([120 / FIRST.a, 20 / FIRST.b])
    deviation = 0.1 * math.sqrt(frames)
    assert (np.abs(logs.mean(axis=0) - expected) < 4 * deviation / math.sqrt(n)).all()
    np.testing.assert_allclose(logs.std(axis=0), deviation, rtol=0.03)
    np.testing.assert_allclose(logs[:, 0] - logs[:, 1], expected[0] - expected[1], atol=1e-9)
    np.testing.assert_array_equal(out[:, :2], 0)


# The state of Maggio et al.


def outline(ellipse: Floats) -> Floats:
    """Return the matrix whose unit ball the ellipse is: the same after any half turns."""
    a, b, theta = ellipse[2:]
    turn = np.array([[math.cos(theta), -math.sin(theta)], [math.sin(theta), math.cos(theta)]])
    matrix: Floats = turn @ np.diag([a**2, b**2]) @ turn.T
    return matrix


sizes = st.floats(1, 100)


@given(st.floats(-99, 99), st.floats(-99, 99), sizes, sizes, st.floats(-7, 7))
def test_minor_axis_eccentricity_and_angle(
    x: float, y: float, a: float, b: float, theta: float
) -> None:
    ellipse = np.array([[x, y, a, b, theta]])
    model = EllipseWalk()
    [state] = model.initial(ellipse)
    [back] = model.ellipses(state[None])
    np.testing.assert_array_equal(back[:2], [x, y])
    assert back[2] >= back[3] * (1 - 1e-15)
    np.testing.assert_allclose(outline(back), outline(ellipse[0]), atol=1e-9 * max(a, b) ** 2)
    assert state[2] == min(a, b)
    assert state[3] == pytest.approx(math.sqrt(1 - (min(a, b) / max(a, b)) ** 2))
    # What was the longer axis still is.
    along = theta if a >= b else theta + math.pi / 2
    assert math.cos(2 * (state[4] - along)) == pytest.approx(1)


@pytest.mark.parametrize("frames", [0.25, 1.0, 3.0])
def test_noise_of_the_paper(frames: float) -> None:
    """Section 5: 5.5 pixels, 0.05 of h, 0.021, 10 degrees; each by itself, all of it Gaussian."""
    n = 60_000
    states = np.tile([200.0, 100, 30, 0.6, 0.4], (n, 1))
    out = EllipseWalk().propagate(
        np.random.default_rng(2), states, frames * FRAME_INTERVAL, Ellipse(9, 9, 5, 4)
    )
    out[:, 2], states[:, 2] = np.log(out[:, 2]), np.log(states[:, 2])
    deviations = np.array([5.5, 5.5, 0.05, 0.021, math.radians(10)]) * math.sqrt(frames)
    z = (out - states) / deviations
    assert np.abs(z.mean(axis=0)).max() < 4.5 / math.sqrt(n)
    np.testing.assert_allclose(np.cov(z.T), np.eye(5), atol=0.025)
    assert np.abs((z**3).mean(axis=0)).max() < 0.06
    assert np.abs((z**4).mean(axis=0) - 3).max() < 0.15


def test_a_circle_grows_and_shrinks_alike_in_both_directions() -> None:
    """The eccentricity is reflected at 0 and stays below 1: half-axes differ tenfold at most."""
    model = EllipseWalk(eccentricity=0.3)
    states = model.initial(np.tile([50.0, 50, 20, 20, 0], (5000, 1)))
    np.testing.assert_allclose(states[:, 3], 0)
    out = model.propagate(np.random.default_rng(0), states, FRAME_INTERVAL, FIRST)
    assert out[:, 3].mean() == pytest.approx(0.3 * math.sqrt(2 / math.pi), rel=0.05)
    for _ in range(20):
        out = model.propagate(np.random.default_rng(1), out, FRAME_INTERVAL, FIRST)
        assert out[:, 3].min() >= 0
        assert out[:, 3].max() <= 0.995
    ellipses = model.ellipses(out)
    assert (ellipses[:, 2] >= ellipses[:, 3]).all()
    assert (ellipses[:, 2] < 10.02 * ellipses[:, 3]).all()
    assert out[:, 3].max() == 0.995


# The state of Zhao and Pei


def equation_17(k: float, p: float, k_size: float) -> Floats:
    """Return A for x, y, s, xp, yp, sp, w, h, x0, y0, theta; s lacks what its origin adds."""
    a = np.eye(11)
    for now, before, origin in ((0, 3, 8), (1, 4, 9)):
        a[now, now], a[now, before], a[now, origin] = k + p, -k * p, 1 - (k + p) + k * p
        a[before, before], a[before, now] = 0, 1
    a[2, 2], a[2, 5], a[5, 5], a[5, 2] = k_size + p, -k_size * p, 0, 1
    return a


@pytest.mark.parametrize("returns", [(0.0, 0.0), (0.0, 0.1), (0.3, 0.05)])
@pytest.mark.parametrize("persistence", [0.0, 0.5, 1.0])
def test_equation_17(returns: tuple[float, float], persistence: float) -> None:
    """From frame to frame: a matrix, and noise of x, y and s alone."""
    model = Autoregressive(
        position=0.1,
        size=0.01,
        persistence=persistence,
        position_return=returns[0],
        size_return=returns[1],
    )
    n, k, k_size = 40_000, 1 - returns[0], 1 - returns[1]
    state = np.array([210.0, 95, 1.2, 204, 99, 1.1, 60, 20, 190, 105, 0.3])
    expected = equation_17(k, persistence, k_size) @ state
    expected[2] += 1 - (k_size + persistence) + k_size * persistence
    out = model.propagate(np.random.default_rng(5), np.tile(state, (n, 1)), FRAME_INTERVAL, FIRST)
    deviations = np.zeros(11)
    deviations[:3] = 0.1 * math.sqrt(60 * 25), 0.1 * math.sqrt(60 * 25), 0.01
    assert (np.abs(out.mean(axis=0) - expected) <= 4.5 * deviations / math.sqrt(n) + 1e-9).all()
    np.testing.assert_allclose(out.std(axis=0), deviations, rtol=0.02, atol=1e-9)
    correlation = np.corrcoef(out[:, :3].T)
    np.testing.assert_allclose(correlation, np.eye(3), atol=0.02)


@pytest.mark.parametrize("frames", [0.25, 0.5, 2.0, 3.0])
def test_equation_17_over_any_time(frames: float) -> None:
    """Previous values are those of a reference interval ago: two halves of a way make a whole."""
    model = Autoregressive(position=0, size=0, persistence=0.6, size_return=0.2)
    states = moving(model, 1)
    out = model.propagate(np.random.default_rng(0), states, frames * FRAME_INTERVAL, FIRST)
    change, size = 0.6**frames, 0.8**frames
    np.testing.assert_allclose(out[0, :2], [500 + 7 * frames * change, 400 - 4 * frames * change])
    np.testing.assert_allclose(out[0, :2] - out[0, 3:5], [7 * change, -4 * change])
    # s was 0.99 and is 1: a change of 1 - 1 - 0.8 (0.99 - 1), which is left to the share p.
    assert out[0, 2] - 1 == pytest.approx(0 * size + frames * change * 0.008)
    np.testing.assert_array_equal(out[0, 6:], states[0, 6:])


def test_the_scale_multiplies_both_half_axes_and_the_angle_stays() -> None:
    model = Autoregressive(size=0.2)
    states = model.initial(np.tile(np.array(FIRST), (500, 1)))
    out = model.ellipses(model.propagate(np.random.default_rng(0), states, FRAME_INTERVAL, FIRST))
    np.testing.assert_allclose(out[:, 2] / out[:, 3], FIRST.a / FIRST.b)
    np.testing.assert_array_equal(out[:, 4], FIRST.theta)
    assert out[:, 2].std() > 5
    states[:, 2] = 1.5
    np.testing.assert_allclose(model.ellipses(states)[0], [500, 400, 90, 37.5, 0.1])
