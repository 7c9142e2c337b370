"""Several cues in one filter (Maggio et al., section 4) against equations 8 to 10 by hand."""

import math
from collections.abc import Mapping
from typing import Any
from unittest import mock

import msgspec
import numpy as np
import pytest
from hypothesis import given, strategies as st
from msgspec.structs import replace

from motes import ConfigError, Ellipse, Frame, ParticleFilter
from motes.core import Floats
from motes.core.saved_state import pack
from motes.cues.color import Color
from motes.cues.structure_tensor import Orientation
from motes.sot.filtering import fusion as fusions
from motes.sot.filtering.appearance_rule import AppearanceRule
from motes.sot.filtering.fusion import Fixed, Fusion, PrintedMixture
from motes.sot.filtering.likelihood import Gaussian
from motes.sot.filtering.motion import EllipseWalk
from motes.sot.filtering.resampling import Multinomial
from oracles import moments, region, scene

FIRST = Ellipse(40, 30, 12, 6, 0.2)
NAMES = ["color", "orientation", "edges", "shape"]


def determinants(prior: Floats, likelihoods: Floats, ellipses: Floats, floor: float) -> Floats:
    """Return U of each cue: equation 9 for the share of the predicted covariance."""
    predicted = moments(prior, ellipses)[1]
    units = np.sqrt(np.diag(predicted))
    units[units == 0] = 1
    out = []
    for likelihood in likelihoods:
        found = moments(prior * likelihood, ellipses)[1] + floor**2 * predicted
        out.append(np.linalg.det(found / np.outer(units, units) + 1e-9 * np.eye(5)))
    return np.array(out)


def by_hand(prior: Floats, logs: Floats, ellipses: Floats, floor: float) -> Floats:
    """Return the shares, inversely proportional to U: equation 10."""
    inverse = 1 / determinants(prior, np.exp(logs), ellipses, floor)
    shares: Floats = inverse / inverse.sum()
    return shares


def cloud(seed: int, n: int, cues: int) -> tuple[Floats, Floats, Floats]:
    """Return particles around the first region, log-weights, and log-likelihoods of all kinds."""
    rng = np.random.default_rng(seed)
    ellipses = np.array(FIRST) + rng.normal(size=(n, 5)) * [5, 9, 2, 1, 0.3]
    ellipses[:, 2:4] = np.maximum(ellipses[:, 2:4], 1)
    logs = -rng.uniform(0, 6, (cues, 1)) * rng.random((cues, n)) - rng.uniform(0, 9, (cues, 1))
    return ellipses, rng.normal(size=n), logs


def shares(fusion: Fusion, made: tuple[Floats, Floats, Floats]) -> Floats:
    ellipses, prior, logs = made
    return fusion.fuse(NAMES[: len(logs)], prior, logs, ellipses)[1]


clouds = st.builds(cloud, st.integers(0, 999), st.integers(8, 30), st.integers(2, 4))
floors = st.floats(0.05, 3)


@given(st.dictionaries(st.sampled_from(NAMES), st.floats(1e-6, 1e6)), st.integers(2, 4))
def test_fixed_weights_are_normalized(weights: Mapping[str, float], cues: int) -> None:
    found = shares(Fixed(weights=dict(weights)), cloud(0, 3, cues))
    expected = [weights.get(name, 1.0) for name in NAMES[:cues]]
    np.testing.assert_allclose(found, np.array(expected) / sum(expected))
    assert found.sum() == pytest.approx(1)


@given(clouds)
def test_a_share_is_the_power_of_a_likelihood(made: tuple[Floats, Floats, Floats]) -> None:
    ellipses, prior, logs = made
    fusion = Fixed(weights={"color": 3.0})
    weights, powers = fusion.fuse(NAMES[: len(logs)], prior, logs, ellipses)
    likelihoods = [np.exp(log * len(logs) * w) for log, w in zip(logs, powers, strict=True)]
    expected = np.exp(prior) * np.prod(likelihoods, axis=0)
    np.testing.assert_allclose(weights.values, expected / expected.sum(), rtol=1e-9)


@given(clouds, floors)
def test_equations_7_to_10_as_printed(made: tuple[Floats, Floats, Floats], floor: float) -> None:
    ellipses, prior, logs = made
    names = NAMES[: len(logs)]
    with mock.patch.object(fusions, "FLOOR", floor):
        weights, found = PrintedMixture().fuse(names, prior, logs, ellipses)
    expected = by_hand(np.exp(prior), logs, ellipses, floor)
    np.testing.assert_allclose(found, expected, rtol=1e-5)
    assert found.sum() == pytest.approx(1)
    assert (found > 0).all()
    expected = np.exp(prior) * (found @ np.exp(logs))
    np.testing.assert_allclose(weights.values, expected / expected.sum(), rtol=1e-9)


@given(clouds, st.lists(st.integers(-9, 9), min_size=30, max_size=30))
def test_an_angle_counts_modulo_half_a_turn(
    made: tuple[Floats, Floats, Floats], turns: list[int]
) -> None:
    ellipses, prior, logs = made
    turned = ellipses.copy()
    turned[:, 4] += np.pi * np.array(turns[: len(turned)])
    found = shares(PrintedMixture(), (turned, prior, logs))
    np.testing.assert_allclose(found, shares(PrintedMixture(), made), rtol=1e-5)


def test_one_particle_with_all_the_weight() -> None:
    """It has no spread at all, and yet is not infinitely certain."""
    ellipses, _, _ = cloud(3, 10, 2)
    none = np.zeros(10)
    one, other = (np.where(np.arange(10) == chosen, 0.0, -1e9) for chosen in (2, 7))
    fusion = PrintedMixture()
    found = shares(fusion, (ellipses, none, np.stack([one, other, none])))
    assert np.isfinite(found).all()
    assert found.sum() == pytest.approx(1)
    assert found[0] == pytest.approx(found[1])
    assert found[0] >= found[2] * (1 - 1e-9)
    single = shares(fusion, (ellipses[:1], none[:1], np.zeros((3, 1))))
    np.testing.assert_allclose(single, 1 / 3)
    alike = shares(fusion, (np.tile(ellipses[:1], (10, 1)), none, np.stack([one, none])))
    np.testing.assert_allclose(alike, 0.5)


@pytest.mark.parametrize("bad", [np.nan, -np.inf, np.inf])
@pytest.mark.filterwarnings("ignore:invalid value")
def test_particles_without_a_likelihood(bad: float) -> None:
    ellipses, prior, logs = cloud(2, 12, 2)
    logs[0, 3] = bad
    for fusion in (PrintedMixture(), Fixed()):
        weights, found = fusion.fuse(NAMES[:2], prior, logs, ellipses)
        assert np.isfinite(weights.values).all()
        assert found.sum() == pytest.approx(1)
    logs[0] = bad
    for fusion in (PrintedMixture(), Fixed()):
        weights, found = fusion.fuse(NAMES[:2], prior, logs, ellipses)
        assert np.isfinite([*weights.values, *found]).all()


def with_cues(**changes: Any) -> ParticleFilter:
    config = ParticleFilter(
        particles=50,
        motion=EllipseWalk(position=2.0, size=0.04, angle=0.05),
        color=Color(),
        orientation=Orientation(scale=0.1),
        likelihood=Gaussian(sigma=0.15),
        presence=AppearanceRule(margin=0.5, max_positions=200),
    )
    return replace(config, **changes)


def distances(config: ParticleFilter, models: Any, picture: Frame, ellipses: Floats) -> Floats:
    """Return what each cue says of ellipses."""
    cues = config.cues.items()
    return np.array([cue.distances(models[name], picture, ellipses) for name, cue in cues])


@pytest.mark.parametrize("fusion", [PrintedMixture(), Fixed(weights={"color": 2.0})])
def test_a_step_with_two_cues(fusion: PrintedMixture | Fixed) -> None:
    """Observe, fuse, estimate, judge and learn, put together by hand for a step's particles."""
    config = with_cues(fusion=fusion, resampling=Multinomial(threshold=0.0))
    state, info = config.init(np.random.default_rng(0), scene(0, (40, 30)), region((40, 30)))
    rng = np.random.default_rng(3)
    for index in range(1, 5):
        picture, before = scene(index, (40 + 2 * index, 30)), state
        state, info = config.step(rng, before, picture)
        prior, d = before.weights.values, distances(config, before.models, picture, info.ellipses)
        logs = -(d**2) / (2 * 0.15**2)
        if isinstance(fusion, Fixed):
            alpha = reliable = np.array([2 / 3, 1 / 3])
            pi = prior * np.exp(2 * alpha @ logs)
        else:
            alpha, reliable = by_hand(prior, logs, info.ellipses, 1e-3), np.array([0.5, 0.5])
            pi = prior * (alpha @ np.exp(logs))
        pi /= pi.sum()
        assert list(info.cue_weights) == ["color", "orientation"]
        np.testing.assert_allclose(list(info.cue_weights.values()), alpha, rtol=1e-6)
        np.testing.assert_allclose(info.weights, pi, rtol=1e-6)
        place = info.track.ellipse
        assert place[:4] == pytest.approx(pi @ info.ellipses[:, :4])
        assert info.track.effective_sample_size == pytest.approx(1 / (pi**2).sum(), rel=1e-6)
        there = distances(config, before.models, picture, np.array([place]))[:, 0]
        assert info.track.distance == pytest.approx(math.sqrt(reliable @ there**2), abs=1e-6)
        thresholds = [config.presence.threshold(before.backgrounds[name]) for name in config.cues]
        appears = reliable @ (1 - d**2) > reliable @ thresholds
        assert info.n_supporting == appears.sum() > 0.1 * 50
        sure = config.calibration.probability(info.track.distance)
        assert info.track.confidence == pytest.approx(sure * pi[appears].sum(), abs=1e-6)
        assert info.models == before.models
        for name, cue in config.cues.items():
            learned = cue.update_reading(before.models[name], picture, place)
            assert msgspec.msgpack.encode(state.models[name], enc_hook=pack) == (
                msgspec.msgpack.encode(learned, enc_hook=pack)
            )


def test_names_of_no_cue_in_use_are_refused() -> None:
    two = ParticleFilter(color=Color(), orientation=Orientation())
    replace(two, fusion=Fixed(weights={"orientation": 2.0}))
    message = "fusion.weights names 'edges'; the cues in use are color, orientation"
    with pytest.raises(ConfigError, match=message):
        replace(two, fusion=Fixed(weights={"edges": 2.0}))
