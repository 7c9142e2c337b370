"""Edge orientation (Maggio et al., section 3.2) against plain second implementations."""

import math
from typing import Any, Literal, NamedTuple

import msgspec
import numpy as np
import pytest
from hypothesis import assume, example, given, strategies as st
from numpy.typing import NDArray

from motes import Ellipse, Frame, kernels
from motes.core.types import Floats
from motes.cues.sampling import PROFILES, EveryPixel, Lattice, Sampling, sunflower
from motes.cues.structure_tensor import HYSTERESIS, Filters, Orientation, filters_of
from motes.kernels.structures import PixelGrid, Reading
from oracles import (
    Pixels,
    between_pixels,
    edges,
    frame,
    lattice_places,
    mosaic,
    on_a_border,
    orientation_histogram,
    radii,
    rows,
    structure_tensor,
    triangle,
    wide_regions,
)

Form = Literal["rotated", "fourier"]

FORMS: tuple[Form, ...] = ("rotated", "fourier")
SAMPLINGS: tuple[Sampling, ...] = (EveryPixel(), Lattice())
SCALES = {1: 1.1, 2: 1.9, 3: 2.8}
"""Scales of filters that work on blocks of so many pixels."""

forms = pytest.mark.parametrize("form", FORMS)
pictures = st.builds(mosaic, st.integers(0, 99), st.integers(1, 26), st.integers(1, 26))
scales = st.sampled_from(sorted(SCALES.values()))


class Edges(NamedTuple):
    """Certainty and bins of a plane."""

    certainty: NDArray[np.float32]
    bins: NDArray[np.uint8]


def computed(pixels: Pixels, filters: Filters, count: int = 36) -> Edges:
    """Return the kernel's plane over all blocks."""
    size = tuple(-(-side // filters.step) for side in pixels.shape[:2])
    plane = Edges(np.full(size, np.nan, np.float32), np.full(size, 255, np.uint8))
    kernels.structure_tensor.structure_tensor(pixels, 0, 0, *filters, *plane, count)
    return plane


def tensors(pixels: Pixels, filters: Filters) -> Floats:
    smooth, derivative, window = (taps.astype(np.float64) for taps in filters[1:])
    return structure_tensor(pixels, filters.step, smooth, derivative, window)


def gray(values: Any) -> Pixels:
    """Return a picture of gray values (H, W), rounded."""
    rounded = np.rint(np.asarray(values, float)).clip(0, 255).astype(np.uint8)
    return np.repeat(rounded[:, :, None], 3, axis=2)


def texture(ellipse: Ellipse, size: int = 120, zoom: float = 1.0) -> Frame:
    """Return a smooth pattern that moves, turns and, by `zoom`, grows with an ellipse."""
    y, x = np.mgrid[:size, :size]
    cos, sin = math.cos(ellipse.theta), math.sin(ellipse.theta)
    u = ((x - ellipse.x) * cos + (y - ellipse.y) * sin) / zoom
    v = ((y - ellipse.y) * cos - (x - ellipse.x) * sin) / zoom
    waves = 50 * np.sin(0.5 * u) + 30 * np.sin(0.3 * u + 0.4 * v) + 25 * np.cos(0.015 * u * v)
    return frame(gray(128 + waves))


def replaced(cue: Orientation, **changes: Any) -> Orientation:
    return msgspec.structs.replace(cue, **changes)


@given(st.floats(0.7, 40), st.floats(0.3, 3))
def test_filters_are_gaussians_and_a_derivative(scale: float, window: float) -> None:
    filters = filters_of(scale, window)
    for taps in (filters.smooth, filters.window):
        assert 2 * taps.sum() - taps[0] == pytest.approx(1, abs=1e-6)
    k = np.arange(len(filters.derivative))
    # A slope of one gives one, as antisymmetric taps see it: sum over -r … r of k d(k).
    assert 2 * (k * filters.derivative).sum() == pytest.approx(1, abs=1e-6)
    assert filters.derivative[0] == 0
    ratio = filters.derivative[1:] / (k * filters.smooth)[1:]
    np.testing.assert_allclose(ratio, ratio[0], rtol=1e-5)
    # log of a Gaussian: -k² / (2 sigma²).
    variances = (
        (filters.smooth, (scale / filters.step) ** 2 - (1 - filters.step**-2) / 12),
        (filters.window, (scale / filters.step * window) ** 2),
    )
    for taps, wanted in variances:
        np.testing.assert_allclose(
            np.log(taps / taps[0]), -(np.arange(len(taps)) ** 2) / (2 * wanted), atol=1e-5
        )
        assert (len(taps) - 1) ** 2 >= 2.4**2 * wanted  # so far that little is cut off


def check_plane(found: Edges, tensor: Floats, count: int) -> float:
    """Compare a plane with its tensors; return the share of blocks whose bins were compared."""
    certainty, angles = edges(tensor)
    trace = np.trace(tensor, axis1=2, axis2=3)
    # Single precision: of the gray values, 255 at most, and of sums of squares of differences.
    error = 4e-6 * trace + 2e-4 * np.sqrt(trace) + 1e-8
    assert (np.abs(found.certainty - certainty) <= 2 * trace * error).all()
    spread = np.divide(certainty, trace, out=np.zeros_like(trace), where=trace > 0)
    place = (angles / np.pi + 0.5) * count
    from_border = np.abs(place - np.rint(place)) * np.pi / count
    sure = spread > 0
    sure[sure] &= from_border[sure] > 6e-6 + error[sure] / spread[sure]
    np.testing.assert_array_equal(found.bins[sure], np.floor(place[sure]) % count)
    assert (found.bins < count).all()
    assert np.isfinite(found.certainty).all()
    assert (found.certainty >= 0).all()
    return float(sure.mean())


@given(pictures, scales, st.sampled_from([0.6, 1.0, 1.7]), st.sampled_from([4, 36, 180]))
@example(mosaic(3, 1, 1), 1.1, 1.0, 36)
@example(mosaic(3, 1, 20), 2.8, 1.0, 36)
@example(mosaic(3, 2, 2), 2.8, 1.7, 36)
@example(np.zeros((9, 9, 3), np.uint8), 1.1, 1.0, 36)
@example(np.full((9, 9, 3), 255, np.uint8), 1.9, 1.0, 36)
def test_structure_tensor(pixels: Pixels, scale: float, window: float, count: int) -> None:
    """Equations 3 to 5 by dense convolution and the eigenvectors of each block's tensor."""
    filters = filters_of(scale, window)
    check_plane(computed(pixels, filters, count), tensors(pixels, filters), count)


def turn(y: Any, x: Any) -> Floats:
    """Return the kernel's angle of (x, y) in radians, from -pi."""
    y, x = np.atleast_1d(y).astype(np.float32), np.atleast_1d(x).astype(np.float32)
    out = np.full(y.shape, np.nan, np.float32)
    kernels.gradients.turns(y, x, out)
    return (out.astype(np.float64) - 0.5) * 2 * np.pi


singles = st.floats(-(2.0**50), 2.0**50, width=32)


@given(st.lists(st.tuples(singles, singles), min_size=1, max_size=50))
@example([(y, x) for y in (-1, -0.5, 0, 0.5, 1) for x in (-1, -0.5, 0, 0.5, 1) if (y, x) != (0, 0)])
@example([(1e-45, 1e-44), (1e-44, -1e-45), (1e30, 1e-30), (-1e-30, -1e30), (3e38, -3e38)])
def test_angles(points: list[tuple[float, float]]) -> None:
    """The polynomial is off by 1.14e-5 at most, where x = y; single precision adds its own."""
    y, x = np.array(points, np.float32).T
    off = turn(y, x) - [math.atan2(v, u) for v, u in zip(y.tolist(), x.tolist(), strict=True)]
    off = (off + np.pi) % (2 * np.pi) - np.pi  # a whole turn is none
    off[(x == 0) & (y == 0)] = 0
    assert np.abs(off).max() < 1.2e-5


@st.composite
def fields(draw: st.DrawFn) -> tuple[Edges, int]:
    """Return random certainties and bins, as no picture has them, and the number of bins."""
    rng = np.random.default_rng(draw(st.integers(0, 99)))
    shape, count = (draw(st.integers(1, 20)), draw(st.integers(1, 20))), draw(st.integers(4, 40))
    certainty = rng.gamma(0.5, 100, shape) * (rng.random(shape) > 0.1)
    return Edges(certainty.astype(np.float32), rng.integers(0, count, shape, np.uint8)), count


lattices = st.sampled_from([np.empty((2, 0), np.float32), sunflower(8), sunflower(100)])


def rounding_decides(shape: Any, ellipse: Ellipse, lattice: Any) -> bool:
    """Tell whether a place lies so near a border that rounding decides whether it counts."""
    return between_pixels(ellipse, lattice) if lattice.size else on_a_border(shape, ellipse)


@given(
    fields(),
    wide_regions,
    lattices,
    st.sampled_from(sorted(PROFILES)),
    st.sampled_from([-1.0, 0.0, 30.0, 1e9]),
    st.floats(-100, 100) | st.integers(-100, 100).map(float),
    st.tuples(st.integers(0, 9), st.integers(0, 9)),
)
def test_histograms(
    field: tuple[Edges, int],
    ellipse: Ellipse,
    lattice: NDArray[np.float32],
    profile: str,
    threshold: float,
    shift: float,
    corner: tuple[int, int],
) -> None:
    """Over every place and over a lattice, whatever part of a frame the plane covers."""
    (certainty, bins), count = field
    left, top = corner
    here = ellipse._replace(x=ellipse.x - left, y=ellipse.y - top)
    assume(not rounding_decides(certainty.shape, here, lattice))
    histograms = np.full((1, count), np.nan)
    kernels.structure_tensor.histograms(
        certainty, bins, left, top, rows(ellipse),
        Reading(lattice, PixelGrid(1, 1), PROFILES[profile]), threshold, np.array([shift]),
        histograms,
    )  # fmt: skip
    raw = orientation_histogram(
        certainty.astype(float), bins, here, lattice, profile, threshold, count
    )
    np.testing.assert_allclose(histograms[0], triangle(raw, shift), atol=1e-6)
    assert histograms.sum() == pytest.approx(1) or not histograms.any()


def on_blocks(ellipse: Ellipse, s: int) -> Ellipse:
    """Return an ellipse where it is in a plane of blocks of s pixels."""
    # Block i covers the pixels i s … i s + s - 1, that is, from i s - 1/2 to (i + 1) s - 1/2.
    x, y = (ellipse.x + 0.5) / s - 0.5, (ellipse.y + 0.5) / s - 0.5
    return Ellipse(x, y, ellipse.a / s, ellipse.b / s, ellipse.theta)


def drawn(cue: Orientation, picture: Frame, ellipse: Ellipse, threshold: float) -> Floats:
    """Return the histogram of an ellipse by brute force over the plane of the first region."""
    filters = filters_of(max(0.7, cue.scale * math.sqrt(ellipse.a * ellipse.b)), cue.window)
    certainty, bins = computed(picture.pixels, filters, cue.bins)
    there = on_blocks(ellipse, filters.step)
    assume(not rounding_decides(certainty.shape, there, cue.sampling.lattice))
    raw = orientation_histogram(
        certainty.astype(float), bins, there, cue.sampling.lattice, cue.kernel, threshold, cue.bins
    )
    if cue.form == "rotated":
        return triangle(raw, ellipse.theta / (np.pi / cue.bins))
    smooth = triangle(raw, 0)
    k = np.arange(cue.bins // 2 + 1)
    spectrum: Floats = np.abs(
        np.exp(-2j * np.pi * np.outer(k, np.arange(cue.bins)) / cue.bins) @ smooth
    )
    return spectrum / spectrum.sum() if raw.any() else spectrum


@given(
    st.integers(0, 50),
    st.builds(
        Ellipse,
        st.floats(-5, 60), st.floats(-5, 50), st.floats(2, 40), st.floats(2, 40), st.floats(-4, 4),
    ),
    st.sampled_from([0.05, 0.1, 0.2]),
    st.builds(
        Orientation,
        form=st.sampled_from(FORMS),
        kernel=st.sampled_from(sorted(PROFILES)),
        sampling=st.sampled_from(SAMPLINGS),
        bins=st.sampled_from([9, 36]),
        window=st.sampled_from([0.7, 1.0]),
        kept_fraction=st.sampled_from([0.3, 1.0]),
    ),
)  # fmt: skip
def test_models(seed: int, ellipse: Ellipse, scale: float, cue: Orientation) -> None:
    """From pixels to a model, on blocks of one pixel and of several, in both forms."""
    cue = replaced(cue, scale=scale)
    picture = frame(mosaic(seed, 45, 52))
    model = cue.learn(picture, ellipse)
    dense = replaced(cue, sampling=cue.sampling.dense)
    expected = drawn(dense, picture, ellipse, model.threshold)
    np.testing.assert_allclose(model.histogram, expected, atol=1e-6)
    np.testing.assert_array_equal(model.anchor, model.histogram)
    assert model.histogram.sum() == pytest.approx(1) or not model.histogram.any()


@forms
@pytest.mark.parametrize("gray", [0, 255])
@pytest.mark.parametrize("kept", [0.0, 0.5, 1.0])
def test_without_edges_there_is_nothing(form: Form, gray: int, kept: float) -> None:
    empty, full = frame(np.full((40, 50, 3), gray, np.uint8)), frame(mosaic(1, 40, 50))
    where = Ellipse(20, 20, 10, 7, 0.3)
    for sampling in SAMPLINGS:
        cue = Orientation(form=form, sampling=sampling, kept_fraction=kept)
        nothing = cue.learn(empty, where)
        assert not nothing.histogram.any()
        np.testing.assert_array_equal(cue.distances(nothing, full, rows(where)), 1)
        for model in (nothing, replaced(cue, kept_fraction=0.5).learn(full, where)):
            np.testing.assert_array_equal(cue.distances(model, empty, rows(where, where)), 1)
            assert not cue.observe(model, empty, where).any()
            assert np.isfinite(cue.update_reading(model, empty, where).threshold)


@given(
    st.builds(mosaic, st.integers(0, 9), st.integers(1, 12), st.integers(1, 12)),
    st.sampled_from(FORMS),
    st.sampled_from(SAMPLINGS),
    st.one_of(st.floats(0.4, 2), st.floats(100, 5000)),
    st.one_of(st.floats(0.4, 2), st.floats(100, 5000)),
    st.floats(0, 1),
)
def test_nothing_is_ever_nan(
    pixels: Pixels, form: Form, sampling: Sampling, a: float, b: float, kept: float
) -> None:
    """In a picture smaller than the filter, of a target of one pixel or larger than the frame."""
    picture = frame(pixels)
    cue = Orientation(form=form, sampling=sampling, kept_fraction=kept)
    where = Ellipse(pixels.shape[1] / 2, pixels.shape[0] / 2, a, b, 0.3)
    model = cue.learn(picture, where)
    model = cue.update_reading(model, picture, where)
    assert np.isfinite([*model.histogram, model.scale, model.threshold]).all()
    assert np.isfinite(cue.observe(model, picture, where)).all()
    assert model.histogram.sum() == pytest.approx(1) or not model.histogram.any()
    found = cue.distances(model, picture, rows(where, where._replace(x=-1e4), where))
    assert ((found >= 0) & (found <= 1)).all()


TARGET = Ellipse(60, 58, 40, 25, 0.0)


def test_a_spectrum_does_not_depend_on_the_angle() -> None:
    """Of the picture or of the ellipse: a circle's is all the same."""
    circle = Ellipse(60, 58, 30, 30)
    cue = Orientation(form="fourier", sampling=EveryPixel())
    model = cue.learn(texture(TARGET), circle)
    for degrees in range(0, 180, 15):
        theta = math.radians(degrees)
        turned = texture(TARGET._replace(theta=theta))
        places = rows(circle, circle._replace(theta=theta), circle._replace(theta=1.0))
        found = cue.distances(model, turned, places)
        assert found.max() < 0.08
        np.testing.assert_allclose(found, found[0], atol=1e-6)
    other = cue.distances(model, frame(mosaic(1, 121, 121)), rows(circle))
    assert other[0] > 0.2


@given(
    st.integers(0, 30), st.floats(0, 1), st.sampled_from(SAMPLINGS), st.sampled_from([0.05, 0.2])
)
def test_a_share_of_the_pixels_is_kept(
    seed: int, kept: float, sampling: Sampling, scale: float
) -> None:
    cue = Orientation(kept_fraction=kept, sampling=sampling, scale=scale, kernel="uniform")
    rng = np.random.default_rng(seed)
    picture = frame(rng.integers(0, 256, (60, 70, 3), np.uint8))
    where = Ellipse(30 + seed / 3, 29, 20, 12, 0.4)
    threshold = cue.learn(picture, where).threshold
    filters = filters_of(cue._scale(where), cue.window)
    certainty = computed(picture.pixels, filters).certainty
    there = on_blocks(where, filters.step)
    lattice = sampling.lattice
    assume(not rounding_decides(certainty.shape, there, lattice))
    if lattice.size:
        columns, lines = np.floor(lattice_places(there, lattice)[0] + 0.5).astype(int).T
        values = certainty[lines, columns]
    else:
        values = certainty[radii(certainty.shape, there)[1] < 1]
    # No two pixels are equally certain here; a lattice may read one of them twice.
    same = max(np.unique(values, return_counts=True)[1])
    above = np.count_nonzero(values > threshold)
    assert abs(above - kept * len(values)) <= max(1, same)


@given(st.floats(0.5, 2))
def test_the_scale_changes_when_the_target_has(factor: float) -> None:
    picture = texture(TARGET)
    cue = Orientation(scale=0.06)
    model = cue.learn(picture, TARGET)
    now = TARGET._replace(a=TARGET.a * factor, b=TARGET.b * factor)
    settled = cue.update_reading(model, picture, now)
    assume(abs(abs(factor - 1) - HYSTERESIS) > 1e-9)
    assert settled.scale == pytest.approx(
        model.scale * (factor if abs(factor - 1) > HYSTERESIS else 1)
    )
    fixed = replaced(cue, scale_selection=False).update_reading(model, picture, now)
    assert fixed.scale == model.scale
    # T belongs to the filters that will be used.
    plain = replaced(cue, scale=settled.scale / math.sqrt(now.a * now.b))
    assert settled.threshold == plain.learn(picture, now).threshold


@pytest.mark.parametrize("scale", [0.05, 0.1])
@pytest.mark.parametrize("zoom", [2.0, 3.0])
@forms
def test_a_histogram_does_not_depend_on_the_size(scale: float, zoom: float, form: Form) -> None:
    """Section 3.2.2: with filters that grow with the target; with others it does."""
    small = Ellipse(150, 150, 40, 25, 0.3)
    large = small._replace(a=40 * zoom, b=25 * zoom)
    picture = texture(large, 300, zoom)
    cue = Orientation(scale=scale, sampling=EveryPixel(), form=form)
    model = cue.learn(texture(small, 300), small)
    selected = cue.update_reading(model, picture, large)
    fixed = replaced(cue, scale_selection=False).update_reading(model, picture, large)
    assert selected.scale == pytest.approx(zoom * model.scale)
    assert fixed.scale == model.scale
    near, far = (cue.distances(settled, picture, rows(large))[0] for settled in (selected, fixed))
    assert near < 0.05
    assert far > (2 if form == "rotated" else 1.1) * near
