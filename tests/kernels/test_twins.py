"""Kernels beside plain numpy and SciPy; those that read ellipses have theirs in `oracles.py`."""

import math
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy import fft, ndimage

from motes import kernels
from motes.core.types import Floats
from motes.cues.fourier import irfft2, rfft, rfft2
from motes.cues.search_window import features, sectors
from motes.kernels.structures import NoiseScales, PointCues
from oracles import mosaic

RNG = np.random.default_rng(0)


def assert_close(found: Any, expected: Any, rtol: float = 1e-12) -> None:
    np.testing.assert_allclose(found, expected, rtol=rtol, atol=rtol)


@pytest.mark.parametrize("orders", [0, 1, 2])
def test_walk(orders: int) -> None:
    """A random walk, at constant velocity, at constant acceleration."""
    (a, b), steps, persistence = (9.0, 4.0), 1.5, 0.8
    position, size, returned, aspect, angle = 0.6, 0.5, 0.1, 0.02, 0.1
    changes = np.array([0.5, 0.2])[:orders]
    noise = NoiseScales(position, size, returned, aspect, angle, changes, persistence)
    states = RNG.normal(5, 9, (50, 5 + 4 * orders))
    normal, out = RNG.normal(size=(50, 6 + 4 * orders)), np.empty_like(states)
    kernels.particles.walk(states, normal, noise, steps, (a, b), out)
    spread = np.array([position * math.sqrt(a * b)] * 2 + [aspect * a, aspect * b])
    deviations = np.concatenate([spread, [angle], np.outer(changes, spread).ravel()])
    expected = states + math.sqrt(steps) * deviations * normal[:, :-1]
    kept = persistence**steps
    expected[:, 5:] -= (1 - kept) * states[:, 5:]
    for lower, change in ((5, 9), (0, 5))[2 - orders :]:
        expected[:, lower : lower + 4] += steps * expected[:, change : change + 4]
    growth = math.sqrt(steps) * size * normal[:, -1]
    for column, half in ((2, a), (3, b)):
        far = np.log(np.maximum(expected[:, column], 1) / half)
        scaled = half * np.exp((1 - returned) ** steps * far + growth)
        expected[:, column] = np.maximum(scaled, 1)
    assert_close(out, expected)
    assert (out[:, 2:4] == 1).any()


def test_ancestors() -> None:
    weights = RNG.random(40) * (RNG.random(40) < 0.6)
    positions = np.append(RNG.random(200), [0.0, 1.0])
    chosen = np.empty(positions.size, np.intp)
    kernels.particles.ancestors(weights, positions, chosen)
    sums = np.cumsum(weights)
    last = np.flatnonzero(weights)[-1]
    expected = [next((n for n in range(40) if sums[n] > p * sums[-1]), last) for p in positions]
    np.testing.assert_array_equal(chosen, expected)
    assert (weights[chosen] > 0).all()


def test_combine_and_appearing() -> None:
    distances, shares, weights = RNG.random((3, 40)), RNG.random(3), RNG.random(40)
    out = np.empty(40)
    kernels.particles.combine(distances, shares, out)
    assert_close(out, np.sqrt(shares @ distances**2))
    seen = 1 - distances[0] ** 2 > 0.4
    count, support = kernels.particles.appearing(distances[0], weights, 0.4)
    assert count == np.count_nonzero(seen)
    assert_close(support, weights[seen].sum())


def test_ridge_regression_on_spectra() -> None:
    def spectra(*shape: int) -> NDArray[np.complex64]:
        return (RNG.normal(size=shape) + 1j * RNG.normal(size=shape)).astype(np.complex64)

    learned, seen, label = spectra(4, 50), spectra(4, 50), spectra(50)
    power = RNG.random(50).astype(np.float32) + 1
    out = np.empty_like(label)
    kernels.fourier_ridge.correlate(learned, power, seen, out)
    assert_close(out, (learned.conj() * seen).sum(axis=0) / power, 1e-5)
    numerator, denominator = learned.copy(), power.copy()
    kernels.fourier_ridge.teach(seen, label, 0.3, numerator, denominator)
    assert_close(numerator, 0.7 * learned + 0.3 * label * seen, 1e-5)
    assert_close(denominator, 0.7 * power + 0.3 * (np.abs(seen) ** 2).sum(axis=0), 1e-5)


def test_a_response_is_padded_and_centered() -> None:
    """As numpy's transforms want it, with more values than there are frequencies."""
    shape, more = (7, 9), (14, 18)
    learned, first = (np.fft.rfft2(RNG.normal(size=shape)).astype(np.complex64) for _ in range(2))
    out = np.empty((14, 10), np.complex64)
    kernels.fourier_ridge.pad(learned, first, 0.3, 4.0, out)
    plane = np.fft.irfft2(out, more).astype(np.float32)
    expected = np.fft.irfft2(0.7 * learned + 0.3 * first, shape)
    assert_close(plane[::2, ::2], expected, 1e-4)
    for size in ((7, 10), (6, 9)):
        values, middle = RNG.random(size).astype(np.float32), np.empty(size, np.float32)
        kernels.fourier_ridge.center(values, middle)
        np.testing.assert_array_equal(middle, np.fft.fftshift(values))


def test_cells_of_sizes_are_those_of_each_size() -> None:
    pixels, place = mosaic(3, 60, 80), (38.0, 31.0, 11.0, 16.0, 0.2)
    factors, tapers = np.array([0.8, 1.0, 1.3]), np.array([0.1, 1.0, 0.4], np.float32)
    out, window = np.empty((30 * 4 * 3, 3), np.float32), np.empty((3, 16, 12), np.float32)
    kernels.search_window.cells_of_sizes(pixels, place, factors, tapers, 4, 3, sectors(), out)
    for n, factor in enumerate(factors.tolist()):
        step = 22 * factor / 12, 32 * factor / 16
        kernels.search_window.cut_around(pixels, place, step, window)
        np.testing.assert_array_equal(out[:, n], tapers[n] * features(window).ravel())
    across, down = np.array([np.cos(0.2), np.sin(0.2)]), np.array([-np.sin(0.2), np.cos(0.2)])
    corner = np.array(place[:2]) - 5.5 * step[0] * across - 7.5 * step[1] * down
    again = np.empty_like(window)
    kernels.search_window.cut(
        pixels, tuple(corner.tolist()), tuple((step[0] * across).tolist()),
        tuple((step[1] * down).tolist()), again,
    )  # fmt: skip
    assert_close(window, again, 1e-3)


def test_colors_in_a_box_and_outside_of_another() -> None:
    samples = RNG.uniform(0, 256, (3, 20, 30)).astype(np.float32)
    red, green, blue = samples.astype(int) // 8
    number = (red * 32 + green) * 32 + blue
    rows, columns = np.mgrid[:20, :30]

    def box(left: float, top: float, right: float, bottom: float) -> NDArray[np.bool_]:
        inside: NDArray[np.bool_] = (columns >= left) & (columns < right) & (rows >= top)
        inside &= rows < bottom
        return inside

    inner, outer = (10.5, 5.0, 20.0, 14.2), (8.0, 3.0, 23.0, 17.0)
    inside, outside = np.zeros((2, 32**3), np.float32)
    kernels.color_posterior.add_colors(samples, inner, outer, 0.4, inside, outside)
    for found, where in ((inside, box(*inner)), (outside, ~box(*outer))):
        assert_close(found, 0.4 * np.bincount(number[where], minlength=32**3) / where.sum(), 1e-5)
    sums = np.empty((21, 31))
    kernels.color_posterior.color_integral(samples, inside, outside, sums)
    posterior = (inside[number] + 1e-6) / (inside[number] + outside[number] + 2e-6)
    assert_close(np.diff(np.diff(sums, axis=0), axis=1), posterior, 1e-6)
    assert not sums[0].any()
    assert not sums[:, 0].any()


@pytest.mark.parametrize("shape", [(20, 31), (1, 3)])
def test_texture(shape: tuple[int, int]) -> None:
    gray = RNG.uniform(0, 256, shape).astype(np.float32)
    out = np.empty((3, *shape), np.float32)
    kernels.color_posterior.texture(gray, out)
    means = ndimage.uniform_filter(gray.astype(float), 5, mode="nearest")
    deviations = ndimage.uniform_filter(np.abs(gray - means), 5, mode="nearest")
    assert_close(out, np.stack([means, gray, 4 * deviations]), 1e-3)


def bilinear(plane: Floats, x: float, y: float) -> float:
    """Return a plane's value between four of its values."""
    j, i = min(int(x), plane.shape[1] - 2), min(int(y), plane.shape[0] - 2)
    u, v = x - j, y - i
    return float(np.array([1 - v, v]) @ plane[i : i + 2, j : j + 2] @ np.array([1 - u, u]))


def test_values_between_points() -> None:
    plane, points = RNG.random((9, 12)).astype(np.float32), RNG.uniform(-9, 9, (80, 2))
    out = np.empty(80)
    kernels.bilinear.look_up(plane, points, 1.25, out)
    for value, (x, y) in zip(out, points / 1.25 + np.array([6, 4]), strict=True):
        inside = 0 <= x <= 11 and 0 <= y <= 8
        assert_close(value, bilinear(plane.astype(float), x, y) if inside else 0)
    assert (out == 0).any()


def test_means_over_boxes() -> None:
    integral = np.zeros((16, 21))
    integral[1:, 1:] = RNG.random((15, 20)).cumsum(axis=0).cumsum(axis=1)
    boxes = np.column_stack([RNG.uniform(-12, 12, (60, 2)), RNG.uniform(0.2, 7, (60, 2))])
    means = np.empty(60)
    kernels.bilinear.box_means(integral, boxes, means)
    middle = np.array([10, 7.5, 0, 0])
    for mean, (x, y, across, down) in zip(means, boxes + middle, strict=True):
        left, top = np.clip(x - across, 0, 19), np.clip(y - down, 0, 14)
        right, bottom = np.clip(x + across, left + 1, 20), np.clip(y + down, top + 1, 15)
        total = bilinear(integral, right, bottom) - bilinear(integral, left, bottom)
        total += bilinear(integral, left, top) - bilinear(integral, right, top)
        assert_close(mean, total / ((right - left) * (bottom - top)), 1e-9)


def point_cues() -> PointCues:
    """Return what is known of the points of a window in which one is alike."""
    response, integral = RNG.random((18, 24)).astype(np.float32), np.zeros((33, 41))
    integral[1:, 1:] = RNG.random((32, 40)).cumsum(axis=0).cumsum(axis=1)
    return PointCues(response, 2.0, integral, (3.0, 4.0), 0.3, 0.1, (9.0, 5.0))


def test_points_are_weighed_by_responses_and_colors() -> None:
    cues, points = point_cues(), RNG.normal(0, 9, (60, 2))
    values, means, logs = np.empty((3, 60))
    kernels.localization.weigh(cues, points, logs)
    kernels.bilinear.look_up(cues.response, points, cues.step, values)
    boxes = np.hstack([points, np.tile(cues.core, (60, 1))])
    kernels.bilinear.box_means(cues.integral, boxes, means)
    expected = (0.7 * values + 0.3 * means) / 0.1
    assert_close(logs, expected - ((points / cues.deviation) ** 2).sum(axis=1) / 2)
    kernels.localization.weigh(cues._replace(deviation=(math.inf, math.inf)), points, logs)
    assert_close(logs, expected)


def test_particles_are_drawn_in_three_layers() -> None:
    cues, normal, offsets = point_cues(), RNG.normal(size=(3, 50, 2)), RNG.random(4)
    counts = np.arange(51) // 2 + 5
    found = kernels.localization.draw(cues, normal, offsets, (8.0, 6.0), 1.5, 2.0, counts)
    row, column = np.unravel_index(cues.response.argmax(), cues.response.shape)
    points = normal[0] * (8.0, 6.0)
    points[1::2] = normal[0, 1::2] * 1.5 + np.array([column - 12, row - 9]) * 2.0
    for layer in (1, 2):
        logs = np.empty(len(points))
        kernels.localization.weigh(cues, points, logs)
        sums = np.exp(logs - logs.max()).cumsum()

        def selected(offset: float, n: int, points: Floats = points, sums: Floats = sums) -> Floats:
            positions = (np.arange(n) + offset) / n * sums[-1]
            out: Floats = points[np.searchsorted(sums, positions, side="right")]
            return out

        squares = np.floor(selected(offsets[2 * layer - 2], len(points)) / 2.0)
        left = int(counts[len(np.unique(squares, axis=0))])
        points = selected(offsets[2 * layer - 1], left) + normal[layer, :left] * 1.5 / (2 * layer)
    assert_close(found, points)
    assert 5 < len(found) < 50


@pytest.mark.parametrize("least", [0.0, 3.0, 20.0])
def test_two_pictures_differ_by_a_mean_and_a_median_ratio(least: float) -> None:
    one, other = RNG.uniform(0, 10, (2, 12, 15)).astype(np.float32)[:, :, 2:]
    known = (one > least) & (one < 9) & (other > least) & (other < 9)
    expected = np.median(one[known] / other[known]) if known.any() else 0.0
    assert_close(kernels.planes.mean_difference(one, other), np.abs(one - other).mean(), 1e-5)
    count, ratio = kernels.planes.median_ratio(one, other, least, 9.0)
    assert count == np.count_nonzero(known)
    assert_close(ratio, expected)


@pytest.mark.parametrize("columns", [70, 71])
@pytest.mark.parametrize(
    "every", [1, 4, 16], ids=["alike", "some differ", "those looked at differ"]
)
def test_the_median_ratio_is_that_of_all_points(columns: int, every: int) -> None:
    """Most are left out after a look at every 16th, which may be unlike the others."""
    other = RNG.uniform(50, 90, (91, columns)).astype(np.float32)
    one = other * RNG.choice(np.linspace(0.9, 1.1, 30), other.shape).astype(np.float32)
    one.ravel()[::every] *= 1.5
    count, ratio = kernels.planes.median_ratio(one, other, 10.0, 200.0)
    assert count == other.size
    assert ratio == np.median(one / other)


@pytest.mark.parametrize("columns", [1, 2, 31, 700, 701])
@pytest.mark.parametrize("levels", [3, 2**20])
def test_medians_of_rows(columns: int, levels: int) -> None:
    rows = RNG.integers(0, levels, (5, columns + 2)).astype(np.float32)[:, 1:-1]
    before, out = rows.copy(), np.empty(5, np.float32)
    kernels.planes.medians(rows, out)
    np.testing.assert_array_equal(out, np.median(rows, axis=1))
    np.testing.assert_array_equal(rows, before)
    for some in (rows[:4], rows[:, :0]):
        with pytest.raises(ValueError, match="medians needs a place for the median of each row"):
            kernels.planes.medians(some, out)


def test_the_spread_of_places_by_their_covariance() -> None:
    places = RNG.normal(size=(50, 2)) @ RNG.normal(size=(2, 2))
    covariance = np.cov(places.T)
    expected = math.sqrt(math.sqrt(np.linalg.det(covariance)) / (9.0 * 4.0))
    assert_close(kernels.particles.spread(covariance, (9.0, 4.0)), expected)
    assert kernels.particles.spread(np.zeros((5, 5)), (9.0, 4.0)) == 0


FAST = [n for n in range(1, 130) if fft.next_fast_len(n, real=True) == n]


def test_planes_have_the_same_transforms() -> None:
    for n in FAST:
        for shape in ((2, n, 12), (3, 15, n), (n, n)):
            planes = RNG.normal(size=shape).astype(np.float32)
            spectra = rfft2(planes)
            np.testing.assert_array_equal(spectra, fft.rfft2(planes), err_msg=str(shape))
            back = irfft2(spectra, shape[-1])
            np.testing.assert_array_equal(back, fft.irfft2(spectra, shape[-2:]), err_msg=str(shape))


def test_frequencies_that_are_left_out_are_none() -> None:
    few = rfft2(RNG.normal(size=(2, 24, 6)).astype(np.float32))
    for columns in (8, 9, 40):
        np.testing.assert_array_equal(irfft2(few, columns), fft.irfft2(few, (24, columns)))


def test_lines_of_any_length_have_transforms() -> None:
    """All with small factors and all primes are the same; the others are so but for rounding."""
    for n in range(1, 34):
        lines = RNG.normal(size=(11, n)).astype(np.float32)
        spectra = rfft(lines)
        back = irfft2(spectra[:, None], n)[:, 0]
        same = n in FAST or all(n % factor for factor in range(2, n))
        off = 0.0 if same else 1e-5
        np.testing.assert_allclose(spectra, fft.rfft(lines), 0, off, err_msg=str(n))
        np.testing.assert_allclose(back, fft.irfft(spectra, n), 0, off, err_msg=str(n))


@pytest.mark.parametrize(("wide", "high"), [(4, 7), (1, 20), (30, 2), (99, 99)])
def test_a_filter_is_confined_to_a_box(wide: int, high: int) -> None:
    n, penalty = 20, np.float32(0.1)
    learned, multiplier = (rfft2(RNG.normal(size=(3, n, n)).astype(np.float32)) for _ in range(2))
    mask = np.zeros((n, n), np.float32)
    top, left = (max(n - size, 0) // 2 for size in (high, wide))
    mask[top : top + high, left : left + wide] = 1
    expected = fft.rfft2(fft.irfft2(penalty * learned + multiplier, (n, n)) * mask) / penalty
    moved, copied = multiplier.copy(), np.empty_like(learned)
    kernels.fourier_ridge.confine(learned, 0.1, wide, high, moved, copied)
    np.testing.assert_array_equal(copied, expected)
    np.testing.assert_array_equal(moved, multiplier + penalty * (learned - expected))


@pytest.mark.parametrize("rounds", [1, 2, 4])
def test_rounds_alternate_from_nothing(rounds: int) -> None:
    spectra, before, copied, multiplier = (
        rfft2(RNG.normal(size=(3, 16, 16)).astype(np.float32)) for _ in range(4)
    )
    label, expected, found = spectra[0].copy(), np.empty_like(spectra), np.empty_like(spectra)
    copied[:], multiplier[:] = 0, 0
    for left in reversed(range(rounds)):
        penalty = 1.0 if left == rounds - 1 else 0.1
        kernels.fourier_ridge.solve(
            spectra, label, before, copied, multiplier, penalty, 15.0, expected
        )
        if left:
            kernels.fourier_ridge.confine(expected, penalty, 5, 7, multiplier, copied)
    kernels.fourier_ridge.alternate(spectra, label, before, 15.0, (1.0, 0.1), rounds, 5, 7, found)
    np.testing.assert_array_equal(found, expected)


def test_ridge_regression_refuses_sizes_that_do_not_fit() -> None:
    """Memory beside an array is not touched, whatever a saved tracker holds."""
    spectra, power = np.ones((2, 6), np.complex64), np.ones(6, np.float32)
    plane, large = np.ones((2, 3), np.complex64), np.ones((4, 5), np.complex64)
    ridge = kernels.fourier_ridge
    for short in (spectra[:, :5].copy(), spectra[:1]):
        with pytest.raises(ValueError, match=r"^teach needs a filter \(K, F\)"):
            ridge.teach(spectra, spectra[0], 0.3, short, power)
        with pytest.raises(ValueError, match=r"^correlate needs a filter \(K, F\)"):
            ridge.correlate(short, power, spectra, spectra[0])
    with pytest.raises(ValueError, match=r"^pad needs two responses of one size"):
        ridge.pad(plane, large, 0.3, 4.0, large)
    with pytest.raises(ValueError, match=r"^center needs two planes of one size"):
        ridge.center(np.ones((2, 3), np.float32), np.ones((2, 2), np.float32))


@pytest.mark.parametrize(("step", "block"), [(1, 1), (1, 4), (3, 2)])
def test_what_tells_a_cut(step: int, block: int) -> None:
    rgb = mosaic(0, 21, 34)
    bgr = rgb[:, :, ::-1].copy()[:, :, ::-1]
    for picture in (rgb, bgr, np.broadcast_to(rgb[:, :, :1], rgb.shape)):
        points = picture[::step, ::step].astype(int)
        height, width = (side // block for side in points.shape[:2])
        colors, sums = np.empty(512), np.empty((height, width))
        apart = kernels.cuts.look(picture, step, block, colors, sums)
        codes = (points // 32) @ (64, 8, 1)
        np.testing.assert_array_equal(colors, np.bincount(codes.ravel(), minlength=512))
        whole = points[: height * block, : width * block]
        blocks = whole.reshape(height, block, width, block, 3)
        np.testing.assert_array_equal(sums, blocks.sum(axis=(1, 3, 4)))
        assert apart == np.ptp(points, axis=2).mean()
