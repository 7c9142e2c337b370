"""The filter against the Kalman filter, and its step against figure 2 of Nummiaro et al."""

import math
from typing import Any

import msgspec
import numpy as np
import pytest
from hypothesis import given, strategies as st
from msgspec.structs import replace

from motes import Ellipse, ParticleFilter, Status
from motes.core.config import from_dict
from motes.core.frame import FRAME_INTERVAL, Frame
from motes.core.saved_state import pack
from motes.core.types import Floats
from motes.cues.color import Color, ColorModel
from motes.sot.filtering.appearance_rule import AppearanceRule, Calibration
from motes.sot.filtering.likelihood import Exponential, Gaussian
from motes.sot.filtering.motion import ConstantVelocity, EllipseWalk, Noise, RandomWalk, SecondOrder
from motes.sot.filtering.resampling import (
    RESAMPLINGS,
    KldSampling,
    Multinomial,
    Resampling,
    Systematic,
    Weights,
    mean_ellipse,
)
from motes.sot.known_target import scatter
from motes.sot.particle_state import FilterState
from motes.sot.presets import ADAPTIVE, NUMMIARO, ZHAO_PEI
from oracles import frame, moments, region, scene


class Measuring:
    """A cue whose distance is the one between an ellipse's center and a measured point."""

    def __init__(self, points: Floats) -> None:
        self.points = points

    def learn(self, frame: Frame, ellipse: Ellipse) -> ColorModel:
        """Return something."""
        return ColorModel(np.ones(1), np.ones(1))

    def distances(self, model: Any, frame: Frame, ellipses: Floats) -> Floats:
        """Return the distances of ellipses (N, 5) from the frame's point."""
        out: Floats = np.hypot(*(ellipses[:, :2] - self.points[frame.index]).T)
        return out

    def update_reading(self, model: Any, frame: Frame, ellipse: Ellipse) -> Any:
        """Return the model itself."""
        return model


SIGMA = 2.5
FIRST = Ellipse(30, 40, 10, 20)
BLANK = np.zeros((16, 16, 3), np.uint8)
NOISE = Noise(position=0.1, size=0, size_return=0, aspect=0)
Linear = RandomWalk | ConstantVelocity
MODELS: list[Linear] = [
    RandomWalk(noise=NOISE),
    ConstantVelocity(noise=NOISE, velocity=0.8, persistence=0.9),
]
TIMES = FRAME_INTERVAL * np.array([0, 1, 2, 4, 4.5, 5.5])
"""Some frames are missing, and some are early."""
POINTS = np.array([[30, 40], [31, 43], [29, 44], [33, 41], [36, 40], [38, 37.0]])


def linear_gaussian(
    motion: Linear, particles: int, threshold: float, scheme: str
) -> ParticleFilter:
    """Return a particle filter for a world that a Kalman filter knows exactly."""
    config = ParticleFilter(
        particles=particles,
        motion=motion,
        likelihood=Gaussian(sigma=SIGMA),
        color=Color(),
        resampling=from_dict({"type": scheme, "threshold": threshold}, Resampling),
        presence=AppearanceRule(frames=10**9, max_positions=100),
        calibration=Calibration(width=1e3),
    )
    config.__dict__["cues"] = {"color": Measuring(POINTS)}
    return config


def run(config: ParticleFilter, seed: int) -> tuple[Floats, list[float]]:
    """Return the estimated centers and the logarithms of the likelihood's estimates."""
    rng = np.random.default_rng(seed)
    frames = [Frame(i, float(time), BLANK) for i, time in enumerate(TIMES)]
    state, _ = config.init(rng, frames[0], FIRST)
    # The first frame only fixes where the target is: all particles are there, alike.
    means, evidence = [], []
    for picture in frames[1:]:
        before = state.weights
        due = config.resampling.due(before)
        state, info = config.step(rng, state, picture)
        means.append([info.track.ellipse.x, info.track.ellipse.y])
        gained = state.weights.log - (0.0 if due else before.log)
        prior = np.full(config.particles, 1 / config.particles) if due else before.values
        top = gained.max()
        evidence.append(
            top + math.log(prior @ np.exp(gained - top)) - math.log(2 * math.pi * SIGMA**2)
        )
    return np.array(means), evidence


def kalman(motion: Linear) -> tuple[Floats, Floats, float]:
    """Return exact means (T, 2) and standard deviations (T, 2), and the log-likelihood."""
    means, deviations = np.empty((5, 2)), np.empty((5, 2))
    log_likelihood = 0.0
    unit = math.sqrt(FIRST.a * FIRST.b)
    for axis in range(2):
        m, p = np.array([FIRST[axis], 0.0]), np.zeros((2, 2))
        for t in range(1, len(TIMES)):
            steps = (TIMES[t] - TIMES[t - 1]) / FRAME_INTERVAL
            position = NOISE.position * unit * math.sqrt(steps)
            velocity = 0.0
            f = np.eye(2)
            step = np.array([[1, steps], [0, 1]])
            if isinstance(motion, ConstantVelocity):
                velocity = motion.velocity * position
                f = step @ np.diag([1, motion.persistence**steps])
            m = f @ m
            p = f @ p @ f.T + step @ np.diag([position**2, velocity**2]) @ step.T
            innovation, s = POINTS[t, axis] - m[0], p[0, 0] + SIGMA**2
            log_likelihood -= 0.5 * (innovation**2 / s + math.log(2 * math.pi * s))
            gain = p[:, 0] / s
            m = m + gain * innovation
            p = p - np.outer(gain, p[0])
            means[t - 1, axis], deviations[t - 1, axis] = m[0], math.sqrt(p[0, 0])
    return means, deviations, log_likelihood


@pytest.mark.slow
@pytest.mark.parametrize("motion", MODELS, ids=["random_walk", "constant_velocity"])
@pytest.mark.parametrize(
    ("scheme", "threshold"),
    [(name, 1.0) for name in RESAMPLINGS.names()] + [("systematic", 0.5), ("multinomial", 0.0)],
)
def test_means_and_likelihood(motion: Linear, scheme: str, threshold: float) -> None:
    """In a linear-Gaussian world the Kalman filter knows the answer."""
    exact, _, log_likelihood = kalman(motion)
    config = linear_gaussian(motion, 400, threshold, scheme)
    runs = [run(config, seed) for seed in range(120)]
    means = np.array([means for means, _ in runs])
    error = means.std(axis=0, ddof=1) / math.sqrt(len(runs))
    # Ten numbers: the largest of them is within 3.5 errors, and most are within 2. A mean
    # of weighted particles is biased by a share 1 / N of the spread, which is added.
    z = np.abs(means.mean(axis=0) - exact) / (error + 1 / 400)
    assert z.max() < 3.5
    assert np.median(z) < 1.5
    ratio = np.exp([sum(evidence) - log_likelihood for _, evidence in runs])
    assert abs(ratio.mean() - 1) < 3 * ratio.std(ddof=1) / math.sqrt(len(runs))
    assert ratio.std() < 1.5  # else the line before says nothing


@pytest.mark.slow
@pytest.mark.parametrize("motion", MODELS, ids=["random_walk", "constant_velocity"])
def test_the_error_falls_as_the_root_of_n(motion: Linear) -> None:
    exact, deviations, _ = kalman(motion)
    counts = np.array([50, 200, 800, 3200])
    errors = []
    for n in counts:
        config = linear_gaussian(motion, int(n), 1.0, "multinomial")
        off = [(run(config, seed)[0] - exact)[-1] / deviations[-1] for seed in range(60)]
        errors.append(np.sqrt(np.mean(np.square(off))))
    slope = np.polyfit(np.log(counts), np.log(errors), 1)[0]
    assert slope == pytest.approx(-0.5, abs=0.12)
    assert errors[-1] < 0.1


ellipses_ = st.lists(
    st.tuples(
        st.floats(-99, 99), st.floats(-99, 99), st.floats(1, 50), st.floats(1, 50), st.floats(-1, 1)
    ),
    min_size=1,
    max_size=20,
)


@given(ellipses_, st.integers(0, 99))
def test_estimate(rows: list[tuple[float, ...]], seed: int) -> None:
    """Equation 1, and the covariance, one particle at a time."""
    ellipses = np.array(rows)
    weights = np.random.default_rng(seed).dirichlet(np.ones(len(rows)))
    mean, covariance = mean_ellipse(ellipses, weights)
    expected, by_hand = moments(weights, ellipses)
    np.testing.assert_allclose(mean[:4], expected[:4], atol=1e-9)
    assert math.cos(2 * (mean.theta - expected[4])) == pytest.approx(1, abs=1e-12)
    np.testing.assert_allclose(covariance, by_hand, atol=1e-7)
    np.testing.assert_allclose(covariance, covariance.T, atol=1e-9)
    assert np.linalg.eigvalsh(covariance).min() > -1e-8


def test_half_a_turn_changes_no_ellipse() -> None:
    rows = np.array([[0, 0, 5, 3, 1.5], [0, 0, 5, 3, 1.7 - np.pi], [0, 0, 5, 3, 1.6 + 7 * np.pi]])
    mean, covariance = mean_ellipse(rows, np.full(3, 1 / 3))
    assert math.cos(2 * (mean.theta - 1.6)) == pytest.approx(1)
    assert -math.pi / 2 <= mean.theta <= math.pi / 2
    assert covariance[4, 4] == pytest.approx(np.var([1.5, 1.6, 1.7]))


def begun(**changes: Any) -> tuple[ParticleFilter, FilterState]:
    config = msgspec.structs.replace(ParticleFilter(color=Color()), **changes)
    state, _ = config.init(np.random.default_rng(0), scene(0, (40, 30)), region((40, 30)))
    return config, state


@pytest.mark.slow
@pytest.mark.parametrize("scheme", RESAMPLINGS.names())
def test_a_search_keeps_a_fair_half(scheme: Any) -> None:
    """Half of the particles go on in proportion to their weights, whatever order they are in."""
    n = 8
    config, state = begun(
        particles=n,
        motion=RandomWalk(noise=Noise(position=0, size=0, size_return=0, aspect=0)),
        resampling=from_dict({"type": scheme, "threshold": 0.0}, Resampling),
    )
    weights = np.array([0.3, 0.02, 0.18, 0.1, 0.05, 0.05, 0.1, 0.2])
    states = np.tile(np.array(region((0, 0))), (n, 1))
    states[:, 0] = np.arange(n)
    state = replace(
        state,
        states=states,
        weights=Weights.from_log(np.log(weights)),
        status=Status.SEARCHING,
        search_regions=np.array([[50.0, 50, 20, 10]]),
    )
    picture, rng = scene(1, None), np.random.default_rng(0)
    kept = np.zeros(n)
    runs = 1500
    for _ in range(runs):
        after, _ = config.step(rng, state, picture)
        old = after.states[after.states[:, 1] == 0]
        assert len(old) == n // 2
        fresh = after.states[after.states[:, 1] > 0]
        assert ((fresh[:, 0] >= 49.5) & (fresh[:, 0] < 69.5)).all()
        assert ((fresh[:, 1] >= 49.5) & (fresh[:, 1] < 59.5)).all()
        kept += np.bincount(old[:, 0].astype(int), minlength=n)
    expected = n / 2 * weights
    # A particle's copies vary by no more than multinomial ones do.
    np.testing.assert_allclose(kept / runs, expected, atol=4 * math.sqrt(4 * 0.25 / runs))


def test_spread_is_uniform_over_places_by_their_area() -> None:
    places = np.array([[0.0, 0, 10, 10], [50, 20, 30, 10]])
    size = Ellipse(0, 0, 4, 3, 0.5)
    ellipses = scatter(np.random.default_rng(0), places, size, 40_000)
    np.testing.assert_array_equal(ellipses[:, 2:], np.tile([4, 3, 0.5], (40_000, 1)))
    second = ellipses[:, 0] > 20
    assert second.mean() == pytest.approx(0.75, abs=0.01)
    for inside, (x, y, w, h) in zip((~second, second), places, strict=True):
        centers = ellipses[inside, :2]
        # A box covers its pixels: from half a pixel before its first one's center.
        low, high = np.array([x, y]) - 0.5, np.array([x + w, y + h]) - 0.5
        assert ((centers >= low) & (centers < high)).all()
        np.testing.assert_allclose(centers.mean(axis=0), (low + high) / 2, atol=0.2)
        np.testing.assert_allclose(centers.std(axis=0), (high - low) / 12**0.5, rtol=0.03)
    assert scatter(np.random.default_rng(0), places, size, 0).shape == (0, 5)


def test_one_particle() -> None:
    config, state = begun(particles=1)
    state, info = config.step(np.random.default_rng(0), state, scene(1, (40, 30)))
    assert info.track.effective_sample_size == 1
    np.testing.assert_array_equal(info.track.covariance, 0)
    searching = replace(state, status=Status.SEARCHING)
    config.step(np.random.default_rng(0), searching, frame(scene(2, None).pixels, 2))


CENTERS = [(40 + 2 * i, 30 + i) for i in range(6)] + [None, None, (58, 42), (60, 43)]
"""The target is hidden for a while, so that it is searched for."""
SMALL = replace(NUMMIARO, particles=20, presence=replace(NUMMIARO.presence, frames=1))


def bits(config: ParticleFilter) -> bytes:
    """Return all that steps give over a film, to the last bit."""
    rng = np.random.default_rng(3)
    state, info = config.init(rng, scene(0, CENTERS[0]), region((40, 30)))
    out = [state, info]
    for index, center in enumerate(CENTERS[1:], 1):
        state, info = config.step(rng, state, scene(index, center))
        out += [state, info]
    return msgspec.msgpack.encode(out, enc_hook=pack) + repr(rng.bit_generator.state).encode()


@pytest.mark.parametrize(
    "config",
    [
        SMALL,
        replace(SMALL, adaptation=ADAPTIVE.adaptation),
        replace(SMALL, motion=RandomWalk(noise=Noise(angle=0.1))),
        replace(SMALL, motion=SecondOrder(noise=Noise(angle=0.1))),
        replace(SMALL, likelihood=Gaussian(sigma=0.05, epsilon=0.01)),
        replace(SMALL, likelihood=Gaussian(sigma=0.001)),
        replace(SMALL, color=Color(space="hsv+v", bins=(4, 4, 4), kernel="gaussian")),
        replace(SMALL, budget=KldSampling(min=10, max=40)),
    ],
    ids=["plain", "learns", "walk", "second order", "likelihood", "narrow", "hsv+v", "budget"],
)
def test_one_call_gives_the_same_as_part_by_part(config: ParticleFilter) -> None:
    assert config.color_step is not None
    parts = replace(config)
    parts.__dict__["color_step"] = None
    assert bits(config) == bits(parts)


class Own(Color, frozen=True):
    """A cue that may do something else."""


@pytest.mark.parametrize(
    "changes",
    [
        {"color": None, "extra_cues": {"own": Own()}},
        {"motion": EllipseWalk()},
        {"likelihood": Exponential()},
        {"resampling": Systematic()},
        {"resampling": Multinomial(threshold=0.5)},
        {"hog": ZHAO_PEI.hog},
        {"presence": AppearanceRule(in_frame=True)},
    ],
)
def test_other_parts_are_called_one_by_one(changes: dict[str, Any]) -> None:
    config = replace(SMALL, **changes)
    assert config.color_step is None
    assert bits(config)
