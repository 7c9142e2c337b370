"""What all cues have in common: what they see, and what they refuse."""

from collections.abc import Sequence
from typing import Any

import msgspec
import numpy as np
import pytest
from hypothesis import given, strategies as st

import motes
from motes import ConfigError, Ellipse, kernels
from motes.cues.color import Color, Posterior
from motes.cues.correlation_filter import Correlation, ScaleFilter
from motes.cues.gradients import Edges, Hog
from motes.cues.sampling import DENSE, Checkerboard, EveryPixel, Lattice, Sampling
from motes.cues.search_window import features
from motes.cues.structure_tensor import Orientation
from motes.mot.expected import Expected
from motes.sot.discriminative.expert import Confined
from oracles import bhattacharyya, frame, mosaic, pictures, regions, rows

CUES = (
    Color(),
    Color(space="hsv", bins=(8, 8, 4), kernel="epanechnikov"),
    Color(space="hsv+v", kernel="gaussian"),
    Edges(),
    Hog(),
    Hog(cells=3, bins=5, rotation_normalized=False),
)
"""Cues with a method `histograms`."""
ON_PLANES = (Edges(), Hog(cells=3))
SAMPLINGS: tuple[Sampling, ...] = (
    *(EveryPixel(), Checkerboard(), Checkerboard(share="quarter"), Lattice(points=64)),
)

cues = pytest.mark.parametrize("cue", CUES, ids=repr)
all_cues = pytest.mark.parametrize(
    "cue", [*CUES, Orientation(), Orientation(form="fourier")], ids=repr
)
samplings = pytest.mark.parametrize("sampling", SAMPLINGS, ids=repr)
WHERE = Ellipse(14, 15, 8, 6, 0.2)


def read(cue: Any, sampling: Sampling) -> Any:
    return msgspec.structs.replace(cue, sampling=sampling)


@pytest.mark.slow
@all_cues
@given(pictures, st.lists(regions, min_size=1, max_size=4), regions)
def test_distances(cue: Any, pixels: Any, candidates: list[Ellipse], target: Ellipse) -> None:
    """Over all bins, though a kernel may sum over occupied ones only."""
    picture = frame(pixels)
    for sampling in SAMPLINGS:
        each = read(cue, sampling)
        model = each.learn(picture, target)
        found = each.distances(model, picture, rows(*candidates))
        histograms = [each.observe(model, picture, candidate) for candidate in candidates]
        # Near 0 the distance is the root of what rounding leaves of 1 - rho.
        expected = [bhattacharyya(p, model.histogram) for p in histograms]
        np.testing.assert_allclose(found**2, np.square(expected), atol=1e-12)
        assert ((found >= 0) & (found <= 1)).all()


@cues
def test_what_a_model_learns_from_is_the_region_s_histogram(cue: Any) -> None:
    before, after = frame(mosaic(7, 30, 30)), frame(mosaic(8, 30, 30))
    model = cue.learn(before, WHERE)
    first = read(cue, cue.sampling.dense).histograms(before, rows(WHERE))[0]
    seen = cue.histograms(after, rows(WHERE))[0]
    np.testing.assert_array_equal(model.histogram, first)
    np.testing.assert_array_equal(model.anchor, first)
    np.testing.assert_array_equal(cue.observe(model, after, WHERE), seen)
    assert (seen != first).any()
    assert cue.update_reading(model, after, WHERE) is model
    assert not cue.observe(model, after, WHERE._replace(x=200.0)).any()


@samplings
@all_cues
def test_nothing_is_seen_outside_and_in_no_ellipse(cue: Any, sampling: Sampling) -> None:
    picture, nothing = frame(mosaic(0, 30, 30)), Ellipse(*[np.nan] * 5)
    each = read(cue, sampling)
    model = each.learn(picture, WHERE)
    ellipses = rows(nothing, WHERE, WHERE._replace(x=90.0), WHERE._replace(x=-1e12, y=1e12))
    broken = np.tile(ellipses[1], (8, 1))
    broken[range(5), range(5)] = np.nan
    broken[range(5, 8), (0, 1, 4)] = np.inf
    found = each.distances(model, picture, np.concatenate([ellipses, broken]))
    assert found[1] == pytest.approx(each.distances(model, picture, rows(WHERE))[0], abs=1e-7)
    np.testing.assert_array_equal(np.delete(found, 1), 1)
    lost = each.learn(picture, WHERE._replace(x=90.0))
    assert not lost.histogram.any()
    np.testing.assert_array_equal(each.distances(lost, picture, rows(nothing, WHERE)), 1)


@pytest.mark.parametrize(
    "cue", [*ON_PLANES, Orientation(scale=0.15)], ids=lambda cue: type(cue).__name__
)
@given(pictures, regions)
def test_a_part_is_computed_as_in_the_whole(cue: Any, pixels: Any, ellipse: Ellipse) -> None:
    """Bit for bit: what is kept of a frame must not depend on who asked first."""
    each = read(cue, EveryPixel())
    model = each.learn(frame(pixels), Ellipse(8, 8, 6, 5, 0.4))
    whole, part = frame(pixels), frame(pixels)
    each.distances(model, whole, rows(Ellipse(8, 8, 99, 99)))
    [plane] = whole.cache.values()
    assert plane.bins.shape == pixels.shape[:2]
    expected = each.observe(model, whole, ellipse)
    np.testing.assert_array_equal(each.observe(model, part, ellipse), expected)


GOOD = Ellipse(30.0, 20.0, 8.0, 6.0, 0.2)
WILD = [
    GOOD._replace(**{field: value})
    for field, values in {
        "x": (np.nan, np.inf, -1e300),
        "a": (np.nan, 0.0, -3.0, 1e300),
        "b": (np.inf, -6.0),
        "theta": (np.nan, np.inf),
    }.items()
    for value in values
]
LEARNING: Sequence[Any] = (
    Color(sampling=EveryPixel()), Edges(), Hog(), Orientation(), Posterior(), Correlation(),
)  # fmt: skip
PICTURE = frame(mosaic(0, 40, 60))


@pytest.mark.parametrize(
    "cue", [*LEARNING, ScaleFilter(), Confined()], ids=lambda each: type(each).__name__
)
def test_nothing_is_learned_of_what_is_no_ellipse(cue: Any) -> None:
    for ellipse in WILD:
        with pytest.raises(ConfigError, match="region"):
            cue.learn(PICTURE, ellipse)
    assert cue.learn(PICTURE, GOOD) is not None


@pytest.mark.parametrize("cue", LEARNING, ids=lambda each: type(each).__name__)
def test_no_particle_is_too_wild_to_be_compared(cue: Any) -> None:
    model = cue.learn(PICTURE, GOOD)
    negative = GOOD._replace(a=-8.0, b=-6.0)  # of which a kernel had room for too few pixels
    found = cue.distances(model, PICTURE, rows(*WILD, negative, GOOD))
    np.testing.assert_array_equal(found[:-1], 1)
    assert found[-1] < 0.7
    for turned in (np.asfortranarray(rows(*WILD, GOOD)), rows(*WILD, GOOD).tolist()):
        assert cue.distances(model, PICTURE, turned)[-1] == found[-1]
    for wrong in (rows(GOOD)[:, :4], rows(GOOD)[0], "ellipses", None):
        with pytest.raises(ConfigError, match=r"an array \(N, 5\)"):
            cue.distances(model, PICTURE, wrong)


@pytest.mark.parametrize(
    ("cue", "other"),
    [
        (Color(), Color(bins=(4, 4, 4))), (Color(bins=(4, 4, 4)), Color()),
        (Edges(), Edges(bins=5)), (Edges(bins=5), Edges()), (Hog(), Hog(cells=3)),
        (Orientation(), Orientation(form="fourier", bins=9)), (Color(), Posterior()),
    ],
)  # fmt: skip
def test_a_model_of_other_bins_is_refused(cue: Any, other: Any) -> None:
    """One of fewer bins had a distance, which meant nothing."""
    model = other.learn(PICTURE, GOOD)
    calls = [cue.learn_also, *([cue.shift] if isinstance(cue, Color) else [])]
    with pytest.raises(ConfigError, match="no histogram of"):
        cue.distances(model, PICTURE, rows(GOOD))
    for call in calls:
        with pytest.raises(ConfigError, match="no histogram of"):
            call(model, PICTURE, GOOD)


@pytest.mark.parametrize("wild", [np.nan, np.inf, -np.inf, 1e300, -1e300, 1e19])
def test_a_window_at_any_place_has_the_picture_s_pixels(wild: float) -> None:
    out = np.empty((3, 12, 16), np.float32)
    steps: Sequence[Any] = ((0.5, 0.7), (2.2, 1.5), (wild, 1.0), (-1.3, wild), (0.4, -wild))
    for place in range(5):
        for step in steps:
            ellipse = list(GOOD)
            ellipse[place] = wild
            for theta in (0.0, ellipse[4]):
                target = Ellipse(*ellipse)._replace(theta=theta)
                kernels.search_window.cut_around(PICTURE.pixels, target, step, out)
                assert ((out >= 0) & (out <= 255)).all()


def test_samples_of_any_value_have_a_color_and_a_sector() -> None:
    values = np.array([np.nan, np.inf, -np.inf, 1e30, -5, 300, 7, 255], np.float32)
    samples = np.random.default_rng(0).choice(values, (3, 24, 24))
    inside, outside = np.zeros((2, 32768), np.float32)
    box = (4.0, 4.0, 20.0, 20.0)
    kernels.color_posterior.add_colors(samples, box, box, 1.0, inside, outside)
    assert inside.sum() == pytest.approx(1)
    sums = np.empty((25, 25))
    kernels.color_posterior.color_integral(samples, inside, outside, sums)
    boxes, means = np.array([[np.nan, 1, 2, 3], [1, -np.inf, np.inf, np.nan]]), np.empty(2)
    kernels.bilinear.box_means(sums, boxes, means)
    assert ((means >= 0) & (means <= 1)).all()
    assert features(samples).shape == (30, 6, 6)


@pytest.mark.parametrize("samples", [*([each] for each in WILD), [], [[1.0, 2, 3, 4]], None])
def test_nothing_wild_is_expected(samples: Any) -> None:
    tracker = motes.Tracker("nummiaro")
    tracker.init(PICTURE.pixels, (20, 12, 16, 14))
    scene = motes.Scene(lambda frame: [])
    model = Expected.CUE.learn(PICTURE, GOOD)
    with pytest.raises(ConfigError):
        tracker.expect(samples)
    with pytest.raises(ConfigError):
        scene.expect([Expected(1, samples, np.zeros(2), model, True)])
    with pytest.raises(ConfigError, match="velocity"):
        scene.expect([Expected(1, rows(GOOD), np.array([np.nan, 0]), model, True)])


def test_the_lattice_of_a_model_is_never_thinner() -> None:
    assert [Lattice(points=count).dense.points for count in (8, 2 * DENSE)] == [DENSE, 2 * DENSE]
