"""The cues that the default tracker learns: a correlation filter, a posterior, sizes."""

from typing import Any

import numpy as np
import pytest
from msgspec.structs import replace

from motes import Ellipse, Frame, kernels
from motes.core.types import Spectra
from motes.cues.color import CORE_FRACTION, Posterior, borders, contrast, means
from motes.cues.correlation_filter import (
    UPSAMPLING,
    Correlation,
    CorrelationModel,
    ScaleFilter,
    peak_near,
    sample_response,
)
from motes.cues.fourier import vertex
from motes.cues.search_window import (
    CELL_SIZE,
    FINEST,
    LARGER,
    LEAST_MARGIN,
    SAMPLES,
    TURN,
    WIDEST,
    features,
    grid_of,
    sectors,
)
from oracles import mosaic

TARGET = Ellipse(90.0, 70.0, 20.0, 14.0)


def textured(shift: tuple[float, float] = (0.0, 0.0), zoom: float = 1.0) -> Frame:
    """Return 200x150 pixels of smooth waves, moved, and enlarged around the target's center."""
    y, x = np.mgrid[:150, :200].astype(np.float64)
    x, y = (x - shift[0] - TARGET.x) / zoom, (y - shift[1] - TARGET.y) / zoom
    rng = np.random.default_rng(3)
    image = np.zeros((150, 200, 3))
    for _ in range(30):
        angle, length, phase = rng.uniform(0, np.pi), rng.uniform(8, 40), rng.uniform(0, 6.28)
        wave = np.sin((x * np.cos(angle) + y * np.sin(angle)) * 2 * np.pi / length + phase)
        image += wave[:, :, None] * rng.uniform(-12, 12, 3)
    return Frame(0, 0.0, np.clip(image + 128, 0, 255).astype(np.uint8))


def patch(color: tuple[int, int, int] = (200, 30, 30)) -> Frame:
    """Return a picture of another color with the target's box in `color`."""
    pixels = np.full((150, 200, 3), (40, 90, 160), np.uint8)
    pixels[56:84, 70:110] = color
    return Frame(0, 0.0, pixels)


def seen(model: CorrelationModel, frame: Frame) -> Spectra:
    """Return what a filter reads of the window around the target."""
    return Correlation().spectra(model.grid, model.grid.sample_window(frame, TARGET))


def test_a_window_between_pixels_is_bilinear_and_goes_on_outside() -> None:
    x = np.tile(np.arange(40, dtype=np.uint8)[None, :, None] * 5, (30, 1, 3))
    out = np.empty((3, 4, 60), np.float32)
    kernels.search_window.cut(x, (-10.0, 3.0), (0.5, 0.0), (0.0, 0.5), out)
    expected = np.clip(-10 + 0.5 * np.arange(60), 0, 39) * 5
    np.testing.assert_allclose(out[0], np.tile(expected, (4, 1)), rtol=1e-6)


@pytest.mark.parametrize("step", [(0.6, 0.7), (1.2, 1.0), (2.2, 0.8), (3.6, 5.0)])
@pytest.mark.parametrize("corner", [(10.31, 5.73), (-9.23, -4.13), (70.0, 50.0)])
def test_an_upright_window_is_a_hardly_turned_one(
    step: tuple[float, float], corner: tuple[float, float]
) -> None:
    y, x = np.mgrid[:60, :80]
    pixels = np.stack([2 * x + y, 255 - 2 * x, 3 * y], axis=2).astype(np.uint8)
    out, turned = np.empty((2, 3, 20, 24), np.float32)
    kernels.search_window.cut(pixels, corner, (step[0], 0.0), (0.0, step[1]), out)
    kernels.search_window.cut(pixels, corner, (step[0], 1e-9), (-1e-9, step[1]), turned)
    # Where only one direction is finer than the pixels, a turned window is bilinear in both.
    np.testing.assert_allclose(out, turned, atol=3.1 if min(step) < 1 < max(step) else 1e-3)


@pytest.mark.parametrize("turn", [0.0, 0.7])
def test_points_of_a_window_are_where_its_samples_are(turn: float) -> None:
    pixels = np.zeros((150, 200, 3), np.uint8)
    pixels[:, :, 0], pixels[:, :, 1] = np.arange(200), np.arange(150)[:, None]
    place = TARGET._replace(theta=turn)
    samples = grid_of(place.a, place.b)
    window = samples.sample_window(Frame(0, 0.0, pixels), place)
    column, row = samples.center
    offsets = np.array([[0.5, 0.5], [10.5, -7.5], [-20.5, 12.5]])
    at_samples = [window[:2, round(row + y), round(column + x)] for x, y in offsets.tolist()]
    points = samples.points(place, offsets)
    np.testing.assert_allclose(points, at_samples, atol=1e-3)
    np.testing.assert_allclose(samples.offsets(place, points), offsets, atol=1e-9)


def test_windows_see_every_ellipse_near_their_middle() -> None:
    rng = np.random.default_rng(4)
    samples, place = grid_of(20, 14), TARGET._replace(theta=0.4)
    frame = Frame(0, 0.0, np.zeros((150, 200, 3), np.uint8))
    ellipses = np.array(place) + rng.normal(0, 1, (300, 5)) * (60, 50, 4, 2, 0.6)
    ellipses[:, :2] = np.clip(ellipses[:, :2], 0, (199, 149))
    ellipses[:5, 4] += np.pi  # the same ellipses
    seen = np.zeros(300, np.int64)
    for window, mine in samples.tile_windows(frame, place, ellipses):
        seen[mine] += 1
        across, down = samples.offsets(place._replace(x=window.x, y=window.y), ellipses[mine, :2]).T
        assert (np.abs(across) <= samples.width / 2 + 1e-9).all()
        assert (np.abs(down) <= samples.height / 2 + 1e-9).all()
        assert (abs(np.log(ellipses[mine, 2:4] / window[2:4])) <= np.log(LARGER) / 2 + 1e-9).all()
        turned = (ellipses[mine, 4] - window.theta + np.pi / 2) % np.pi - np.pi / 2
        assert (np.abs(turned) <= TURN / 2 + 1e-9).all()
        assert abs(window.theta - place.theta) <= np.pi / 2 + TURN / 2
    assert (seen == 1).all()


@pytest.mark.parametrize("half", [(1, 1), (4, 4), (30, 50), (960, 540), (300, 3)])
def test_a_window_costs_the_same_whatever_the_target(half: tuple[float, float]) -> None:
    cells = grid_of(*half)
    assert cells.rows * cells.columns * CELL_SIZE**2 < 2 * SAMPLES**2
    assert cells.width <= 2 * half[0] * FINEST * 6  # at least six cells a side
    around = max(sum(half), 2 * LEAST_MARGIN)
    wide, high = 2 * half[0] + around, 2 * half[1] + around
    assert cells.width / (cells.columns * CELL_SIZE) == pytest.approx(2 * half[0] / wide)
    assert cells.height / (cells.rows * CELL_SIZE) == pytest.approx(2 * half[1] / high)


@pytest.mark.parametrize("turn", range(18))
def test_features_of_a_slope_are_its_sector(turn: int) -> None:
    y, x = np.mgrid[:32, :32]
    angle = turn * np.pi / 9
    slope = 128 + 3 * (np.cos(angle) * (x - 16) + np.sin(angle) * (y - 16))
    found = features(np.tile(slope, (3, 1, 1)).astype(np.float32))[:, 2:-2, 2:-2]
    assert (found[:9].argmax(axis=0) == turn % 9).all()
    assert (found[9:27].argmax(axis=0) == turn).all()
    gray = slope.reshape(8, 4, 8, 4).mean((1, 3))[2:-2, 2:-2] / 255 - 0.5
    np.testing.assert_allclose(found[27], gray, atol=1e-5)


def test_the_response_peaks_where_it_was_learned() -> None:
    cue, frame = Correlation(), textured()
    model = cue.learn(frame, TARGET)
    plane, first = cue.responses(model, seen(model, frame))
    rows, columns = plane.shape
    assert np.unravel_index(plane.argmax(), plane.shape) == (rows // 2, columns // 2)
    assert plane.max() == pytest.approx(1, abs=0.05)
    assert peak_near(first, 0.0, 0.0) == pytest.approx(1, abs=0.05)
    assert cue.distances(model, frame, np.array([TARGET]))[0] < 0.05


@pytest.mark.parametrize("shift", [(3.0, 0.0), (-2.5, 4.5), (6.0, -5.0)])
def test_the_response_peaks_at_a_shift_finer_than_a_cell(shift: tuple[float, float]) -> None:
    cue = Correlation()
    model = cue.learn(textured(), TARGET)
    plane, _ = cue.responses(model, seen(model, textured(shift)))
    row, column = np.unravel_index(plane.argmax(), plane.shape)
    step = CELL_SIZE / UPSAMPLING * np.array(model.grid.step(TARGET))
    found = (column - plane.shape[1] // 2) * step[0], (row - plane.shape[0] // 2) * step[1]
    assert CELL_SIZE * model.grid.step(TARGET)[0] > 2
    assert found == pytest.approx(shift, abs=1.0)
    offset = np.divide(shift, model.grid.step(TARGET))
    values = sample_response(plane, np.array([offset, offset + np.array([3.0, 0.0]), -offset]))
    assert values.argmax() == 0
    assert values[0] == pytest.approx(plane.max(), abs=0.05)


def test_the_posterior_is_high_inside_a_patch_and_low_outside() -> None:
    cue, frame = Posterior(), patch()
    model = cue.learn(frame, TARGET)
    integral = cue.integral(model, model.grid.sample_window(frame, TARGET))
    width, height = model.grid.half
    boxes = np.array(
        [[0, 0, CORE_FRACTION * width, CORE_FRACTION * height], [1.8 * width, 0, 4, 4]]
    )
    inside, outside = means(integral, boxes)
    assert inside > 0.95
    assert outside < 0.05
    box = np.array([0.0, 0.0, width, height])
    just_inside, just_outside = borders(integral, box[None])[0]
    assert just_inside > 0.8
    assert just_outside < 0.2
    assert contrast(integral, box) > 0.8
    assert contrast(integral, box + np.array([0.8 * width, 0, 0, 0])) < 0.6
    assert cue.distances(model, frame, np.array([TARGET]))[0] < 0.05


def woven(noise: float = 0.0, tint: int = 0) -> Frame:
    """Return a gray picture of stripes; those of the target are finer. One color has a tint."""
    pixels = np.full((150, 200, 3), 100.0)
    pixels[:, np.arange(200) // 8 % 2 == 0] = 140
    pixels[56:84, 70:110] = np.where(np.arange(40) // 2 % 2 == 0, 140.0, 100.0)[:, None]
    pixels += np.random.default_rng(0).normal(0, noise, pixels.shape) if noise else 0
    pixels[..., 2] += tint
    return Frame(0, 0.0, pixels.clip(0, 255).astype(np.uint8))


@pytest.mark.parametrize(("noise", "tint", "gray"), [(0, 0, True), (2, 0, True), (0, 6, False)])
def test_in_a_gray_film_texture_tells_the_place_and_gray_the_border(
    noise: float, tint: int, gray: bool
) -> None:
    cue, frame = Posterior(), woven(noise, tint)
    model = cue.learn(frame, TARGET)
    place, border = cue.integrals(model, model.grid.sample_window(frame, TARGET))
    box = np.array([0.0, 0.0, *model.grid.half])
    assert (contrast(place, box) > 0.5) == gray
    assert contrast(border, box) < 0.2
    beside = TARGET._replace(x=TARGET.x + 20)
    here, there = cue.distances(model, frame, np.array([TARGET, beside]))
    assert (here < there - 0.2) == gray


def test_texture_is_learned_with_the_colors() -> None:
    cue, pixels = Posterior(learning_rate=1.0), woven().pixels.copy()
    pixels[56:84, 70:110] = 100
    model, plain = cue.learn(woven(), TARGET), Frame(1, 1.0, pixels)
    learned = cue.update_reading(model, plain, TARGET)
    old, new = (cue.distances(each, plain, np.array([TARGET]))[0] for each in (model, learned))
    assert new < 0.3 < old - 0.5


@pytest.mark.parametrize("steps", [-2, 0, 2])
def test_the_sizes_filter_sees_growth(steps: int) -> None:
    cue = ScaleFilter()
    model = cue.learn(textured(), TARGET)
    grown = textured(zoom=cue.step**steps)
    response = cue.response(model, cue.spectra(model, grown, TARGET))
    assert abs(int(response.argmax()) - cue.count // 2 - steps) <= 1


@pytest.mark.parametrize("cue", [Correlation(), Posterior()])
def test_a_cue_that_settles_learns_what_is_there(cue: Any) -> None:
    before, there = textured(), TARGET._replace(x=120.0, a=22.0)
    model = cue.learn(before, TARGET)
    other = Frame(1, 1.0, mosaic(5, 150, 200))
    cue, fixed = replace(cue, learning_rate=0.3), replace(cue, learning_rate=0.0)
    settled = kept = model
    for _ in range(20):
        settled, kept = (
            cue.update_reading(settled, other, there),
            fixed.update_reading(kept, other, there),
        )
    assert settled.place == kept.place == there
    assert settled.grid is kept.grid is model.grid
    learned, known = (cue.distances(each, other, np.array([there]))[0] for each in (settled, kept))
    assert learned < known - 0.1
    was = cue.distances(model, before, np.array([TARGET]))[0]
    back = replace(kept, place=TARGET)
    assert cue.distances(back, before, np.array([TARGET]))[0] == pytest.approx(was)


@pytest.mark.parametrize("top", [-0.4, 0.0, 0.3])
def test_the_top_of_a_parabola_is_found_between_its_values(top: float) -> None:
    low, best, high = (5 - 3 * (place - top) ** 2 for place in (-1, 0, 1))
    assert vertex(low, best, high) == pytest.approx(top)
    assert vertex(2.0, 2.0, 2.0) == 0  # all alike: it is where it was looked for


def test_the_sector_of_a_gradient_is_that_of_its_angle() -> None:
    down, across = np.mgrid[-256:256, -256:256]
    numbers = np.round(np.arctan2(down, across) * 9 / np.pi) % 18
    np.testing.assert_array_equal(sectors(), numbers)


def test_the_taper_is_no_wider_than_the_target_asks_for() -> None:
    square, thin = grid_of(20, 20), grid_of(10, 60)
    hann = np.outer(*(np.hanning(n + 2)[1:-1] for n in (square.rows, square.columns)))
    np.testing.assert_allclose(square.taper, hann, atol=1e-6)
    across = thin.taper[thin.rows // 2]
    offsets = CELL_SIZE * np.abs(np.arange(thin.columns) - (thin.columns - 1) / 2)
    assert ((across > 0) == (offsets < WIDEST / 2 * thin.width)).all()
    assert (across == 0).any()
    assert (thin.taper[:, thin.columns // 2] > 0).all()


def test_a_lesson_off_the_center_is_one_at_the_center() -> None:
    cue, shift = Correlation(), (6.0, -5.0)
    model = cue.learn(textured(), TARGET)
    step = model.grid.step(TARGET)
    spectra = seen(model, textured(shift))
    taught = cue.updated(model, spectra, 1.0, shift[0] / step[0], shift[1] / step[1])
    plane, _ = Correlation(anchor=0).responses(taught, seen(model, textured()))
    row, column = np.unravel_index(plane.argmax(), plane.shape)
    assert abs(column - plane.shape[1] // 2) <= 1
    assert abs(row - plane.shape[0] // 2) <= 1


def test_the_best_response_near_a_place_is_none_outside_of_the_window() -> None:
    first = np.zeros((10, 12), np.float32)
    first[5, 8] = 0.7
    assert peak_near(first, 1.4 * CELL_SIZE, 0.0) == pytest.approx(0.7)
    assert peak_near(first, 0.4 * CELL_SIZE, 0.0) == 0
    assert peak_near(first, 2.0 * CELL_SIZE, 1.6 * CELL_SIZE) == 0
    assert peak_near(first, 90.0 * CELL_SIZE, -90.0 * CELL_SIZE) == 0


def test_a_window_of_many_pixels_a_sample_holds_their_means() -> None:
    pixels = mosaic(2, 60, 80)
    out = np.empty((3, 10, 12), np.float32)
    kernels.search_window.cut(pixels, (10.5, 8.5), (2.0, 0.0), (0.0, 2.0), out)
    blocks = pixels[8:28, 10:34].reshape(10, 2, 12, 2, 3).mean(axis=(1, 3))
    np.testing.assert_allclose(out, np.moveaxis(blocks, 2, 0), rtol=1e-6)
