"""The mean-shift tracker against brute force."""

from typing import Any

import numpy as np
import pytest
from hypothesis import given, strategies as st
from msgspec.structs import replace

from motes import Frame, MeanShift, Tracker, synthetic
from motes.core.geometry import Ellipse, iou
from motes.cues.color import Color
from motes.cues.sampling import DENSE, EveryPixel, Lattice
from motes.sot import mean_shift
from motes.sot.filtering.appearance_rule import AppearanceRule
from oracles import frame, mosaic, region, scene

RNG = np.random.default_rng(0)
FAST = MeanShift(presence=AppearanceRule(max_positions=500))


def rho(config: MeanShift, state: Any, picture: Any, ellipse: Ellipse) -> float:
    distance = config.color.distances(state.model, picture, np.array([ellipse]))[0]
    return float(1 - distance**2)


@given(st.integers(0, 40), st.floats(5, 30), st.floats(5, 30))
def test_rho_never_falls_in_any_picture(seed: int, x: float, y: float) -> None:
    config = replace(FAST, color=replace(FAST.color, bins=(3, 3, 3)))
    state, _ = config.init(RNG, frame(mosaic(seed, 36, 36)), Ellipse(x, y, 6, 5))
    picture = frame(mosaic(seed + 1, 36, 36), 1)
    _, info = config.step(RNG, state, picture)
    before = rho(config, state, picture, Ellipse(x, y, 6, 5))
    assert rho(config, state, picture, info.track.ellipse) >= before - 1e-12


def test_one_iteration_is_the_mean_shift_vector(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(mean_shift, "ITERATIONS", 1)
    monkeypatch.setattr(mean_shift, "SCALE", 0.0)
    state, _ = FAST.init(RNG, scene(0, (40, 36)), region((40, 36)))
    picture = scene(1, (43, 37))
    _, info = FAST.step(RNG, state, picture)
    expected = FAST.color.shift(state.model, picture, region((40, 36)))
    np.testing.assert_allclose(info.track.ellipse[:2], expected)
    assert expected[0] > 41


@pytest.mark.parametrize(("growth", "wanted"), [(1.06, 1.05), (1.0, 1.0), (0.94, 0.95)])
def test_of_three_sizes_the_most_similar_is_taken(growth: float, wanted: float) -> None:
    half = (20.0, 14.0)
    state, _ = FAST.init(RNG, scene(0, (48, 36), half=half), Ellipse(48, 36, *half))
    after = scene(1, (48, 36), half=(half[0] * growth, half[1] * growth))
    _, info = FAST.step(RNG, state, after)
    found = info.track.ellipse
    assert found.a == pytest.approx(half[0] * wanted)
    assert found.a / found.b == pytest.approx(half[0] / half[1])


@pytest.mark.slow
@pytest.mark.parametrize("name", ["nummiaro", "nummiaro:adaptive"])
def test_the_particle_filter_follows_a_target_that_leaps(name: str) -> None:
    """Section VI: it "is able to follow the fast moving object during the whole sequence"."""
    film, values = [*synthetic.jumping((320, 240), frames=60)], []
    for seed in range(3):
        tracker = Tracker(name, seed)
        for picture, (truth,) in film:
            box = truth.ellipse.box
            track = tracker.update(picture) if picture.index else tracker.init(picture, box)
            values.append(float(iou(track.box, box)))
    overlaps = np.reshape(values, (3, 60))
    # In one run in ten or so, frames of the leap are missed by chance.
    assert (overlaps[:, 20:29] > 0).mean() > 0.8
    assert overlaps[:, 42:56].min() > 0.3


def test_the_background_of_a_large_region_is_read_by_a_lattice(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Every pixel of thousands of regions would take half a minute on 12 megapixels."""
    pixels = np.random.default_rng(0).integers(60, 140, (400, 600, 3)).astype(np.uint8)
    pixels[100:300, 200:360] = (220, 40, 40)
    samplings, background = [], AppearanceRule.background

    def noted(rule: AppearanceRule, cue: Color, *rest: Any, **options: Any) -> Any:
        samplings.append(cue.sampling)
        return background(rule, cue, *rest, **options)

    monkeypatch.setattr(AppearanceRule, "background", noted)
    for box in ((200, 100, 160, 200), (200, 100, 20, 20)):
        Tracker("mean_shift").init(Frame(0, 0.0, pixels), box)
    assert samplings == [Lattice(points=DENSE), EveryPixel()]
