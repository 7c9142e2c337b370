"""Histograms of gradients and edges (Zhao and Pei; Ng and Delp) against plain second ones."""

import math
from typing import Any

import numpy as np
import pytest
from hypothesis import assume, example, given, strategies as st
from numpy.typing import NDArray

from motes import Ellipse, kernels
from motes.core.types import Floats
from motes.cues.gradients import DERIVATIVE, SMOOTH, Edges, Hog
from motes.cues.sampling import EveryPixel, Lattice, sunflower
from motes.kernels.structures import PixelGrid, Reading
from oracles import (
    MIDDLE,
    SHARES,
    Pixels,
    between_pixels,
    checkerboard,
    edge,
    edge_bins,
    frame,
    kernel,
    lattice_places,
    mosaic,
    on_a_border,
    pictures,
    radii,
    regions,
    rows,
    smooth_gradient,
    sobel,
)

forms = st.tuples(st.integers(1, 3), st.sampled_from([5, 8]), st.booleans())
"""Cells, bins and whether histograms are turned."""


def by_hand(
    pixels: Pixels, points: list[tuple[int, int, float, float]], cells: int, bins: int, turned: bool
) -> Floats:
    """Return the histogram over pixels (row, column) at places (u, v) in the unit disk.

    Only where rounding decides nothing.
    """
    histogram = np.zeros((cells, cells, bins))
    for row, column, u, v in points:
        if not (0 <= row < pixels.shape[0] and 0 <= column < pixels.shape[1]):
            continue
        gx, gy = smooth_gradient(pixels, row, column)
        strength = math.hypot(gx, gy)
        place = (math.atan2(gy, gx) / (2 * math.pi) + 0.5) * bins + 0.5
        down, across = (v + 1) / 2 * cells, (u + 1) / 2 * cells
        near = min(abs(place - round(place)), abs(down - round(down)), abs(across - round(across)))
        assume(strength == 0 or near > 1e-4)
        weight = math.exp(-(u * u + v * v) / 2) * strength
        histogram[int(down), int(across), int(place) % bins] += weight
    directions = histogram.sum(axis=(0, 1))
    if turned:
        top = np.sort(directions)
        assume(top[-1] == 0 or top[-1] > top[-2] * (1 + 1e-4))
        histogram = np.roll(histogram, -int(directions.argmax()), axis=2)
    return histogram.ravel() / (directions.sum() or 1)


@given(pictures, regions, st.sampled_from(sorted(SHARES)), forms)
@example(mosaic(1, 16, 16), Ellipse(8.1, 8.2, 6, 5, 0.01), "all", (1, 8, True))
@example(mosaic(1, 16, 16), Ellipse(0.1, 15.1, 6, 5, 0.02), "half", (3, 8, True))
@example(mosaic(2, 16, 16), Ellipse(9.1, 7.2, 500, 400, 0.1), "quarter", (3, 8, False))
def test_gradients_of_pixels(
    pixels: Any, ellipse: Ellipse, share: str, form: tuple[int, int, bool]
) -> None:
    """Equations 1 and 2."""
    cells, bins, turned = form
    own, board = radii(pixels.shape, ellipse)[1], checkerboard(pixels.shape, share)
    assume(not on_a_border(pixels.shape, ellipse))
    cos, sin = math.cos(ellipse.theta), math.sin(ellipse.theta)
    points = []
    for row, column in zip(*np.nonzero((own < 1) & (board > 0)), strict=True):
        x, y = column - ellipse.x, row - ellipse.y
        place = (x * cos + y * sin) / ellipse.a, (y * cos - x * sin) / ellipse.b
        points.append((int(row), int(column), *place))
    expected = by_hand(pixels, points, cells, bins, turned)
    cue = Hog(cells=cells, bins=bins, rotation_normalized=turned, sampling=SHARES[share])
    found = cue.histograms(frame(pixels), rows(ellipse))[0]
    np.testing.assert_allclose(found, expected, atol=1e-6)


@given(pictures, regions, st.sampled_from([8, 60]), forms)
@example(mosaic(1, 16, 16), Ellipse(-0.6, -0.7, 9, 4, 0.1), 60, (3, 8, True))
def test_gradients_of_lattice(
    pixels: Any, ellipse: Ellipse, count: int, form: tuple[int, int, bool]
) -> None:
    cells, bins, turned = form
    lattice = sunflower(count)
    assume(not between_pixels(ellipse, lattice))
    places = np.floor(lattice_places(ellipse, lattice)[0] + 0.5).astype(int)
    points = [
        (int(row), int(column), float(u), float(v))
        for (column, row), (u, v) in zip(places, lattice.T, strict=True)
    ]
    expected = by_hand(pixels, points, cells, bins, turned)
    cue = Hog(cells=cells, bins=bins, rotation_normalized=turned, sampling=Lattice(points=count))
    found = cue.histograms(frame(pixels), rows(ellipse))[0]
    np.testing.assert_allclose(found, expected, atol=1e-5)


@given(pictures, regions, st.integers(8, 200), forms)
def test_gradients_at_points_are_those_found_everywhere(
    pixels: Any, ellipse: Ellipse, points: int, form: tuple[int, int, bool]
) -> None:
    """Bit for bit, the pixels at the border of the image too."""
    (cells, bins, turned), lattice = form, sunflower(points)
    gaussian = kernels.sampling.GAUSSIAN
    ellipses = rows(ellipse, ellipse._replace(x=0.0), Ellipse(3, 2, 9, 9))
    strength, numbers = np.empty(pixels.shape[:2], np.float32), np.empty(pixels.shape[:2], np.uint8)
    kernels.hog.gradients(pixels, 0, 0, SMOOTH, DERIVATIVE, strength, numbers, bins)
    expected, found = np.empty((3, cells**2 * bins)), np.empty((3, cells**2 * bins))
    kernels.hog.histograms(
        strength,
        numbers,
        0,
        0,
        ellipses,
        Reading(lattice, PixelGrid(1, 1), gaussian),
        cells,
        turned,
        expected,
    )
    kernels.hog.histograms_at(
        pixels, ellipses, lattice, gaussian, cells, turned, SMOOTH, DERIVATIVE, found
    )
    np.testing.assert_array_equal(found, expected)


def normalized(weights: Floats, bins: NDArray[np.int64], count: int) -> Floats:
    """Return equation 18 over pixels with these weights; -1 is no bin."""
    histogram = np.zeros(count + 1)
    for weight, u in zip(weights.ravel(), bins.ravel(), strict=True):
        if u >= 0:
            histogram[u] += weight
    if not histogram.any():
        histogram[count] = weights.sum()
    return histogram / (histogram.sum() or 1.0)


def sure_bins(pixels: Any, threshold: float, count: int) -> NDArray[np.int64]:
    """Return the bins; only for pictures where rounding decides about no pixel."""
    strength, angle = sobel(pixels)
    assume((abs(strength - threshold) > 1e-3).all())
    places = (angle + math.pi / 2) / math.pi * count + 0.5
    strong = strength > threshold
    assume((abs(places - np.rint(places))[strong] > 1e-4).all())
    return edge_bins(strength, angle, threshold, count)


@given(pictures, regions, st.sampled_from(sorted(SHARES)), st.sampled_from([8, 9, 36]))
@example(mosaic(1, 16, 16), Ellipse(8, 8, 6, 5, 0.0), "all", 8)
@example(mosaic(1, 16, 16), Ellipse(0, 15, 6, 5, 0.0), "half", 8)
@example(mosaic(1, 16, 16), Ellipse(9, 7, 500, 500, 0.1), "quarter", 9)
def test_edges_of_pixels(pixels: Any, ellipse: Ellipse, share: str, count: int) -> None:
    """Equations 10 to 15, 18 and 19."""
    own = radii(pixels.shape, ellipse)[1]
    assume(ellipse.theta == 0 or not on_a_border(pixels.shape, ellipse))
    bins = sure_bins(pixels, 300.0, count)
    cue = Edges(threshold=300.0, bins=count, sampling=SHARES[share])
    found = cue.histograms(frame(pixels), rows(ellipse))[0]
    weights = kernel(own) * checkerboard(pixels.shape, share)
    np.testing.assert_allclose(found, normalized(weights, bins, count), atol=1e-9)


@given(pictures, regions, st.sampled_from([8, 100]))
@example(mosaic(1, 16, 16), Ellipse(-0.5, -0.5, 9, 4, 0.0), 100)
def test_edges_of_lattice(pixels: Any, ellipse: Ellipse, points: int) -> None:
    lattice = sunflower(points)
    assume(not between_pixels(ellipse, lattice))
    places = lattice_places(ellipse, lattice)[0] + 0.5
    bins = sure_bins(pixels, 300.0, 8)
    columns, lines = np.floor(places).astype(int).T
    inside = (columns >= 0) & (lines >= 0)
    inside &= (columns < pixels.shape[1]) & (lines < pixels.shape[0])
    weights = kernel(np.hypot(*lattice.astype(float)))[inside]
    cue = Edges(threshold=300.0, sampling=Lattice(points=points))
    found = cue.histograms(frame(pixels), rows(ellipse))[0]
    expected = normalized(weights, bins[lines[inside], columns[inside]], 8)
    np.testing.assert_allclose(found, expected, atol=1e-6)


def test_without_any_strong_edge() -> None:
    """Flat regions are alike, unlike those with edges, and unlike what lies outside the frame."""
    cue, flat = Edges(), edge((1, 0), 0)
    model = cue.learn(flat, MIDDLE)
    np.testing.assert_array_equal(model.histogram, [0] * 8 + [1])
    outside = MIDDLE._replace(x=90.0)
    np.testing.assert_array_equal(cue.distances(model, flat, rows(MIDDLE, outside)), [0, 1])
    np.testing.assert_array_equal(cue.distances(model, edge((1, 0)), rows(MIDDLE, outside)), 1)
    assert not cue.histograms(flat, rows(outside)).any()


@given(pictures, regions, st.integers(8, 200))
def test_the_operator_at_points_finds_what_it_finds_everywhere(
    pixels: Any, ellipse: Ellipse, points: int
) -> None:
    """Bit for bit, the pixels at the border of the image too."""
    lattice, ellipses = (
        sunflower(points),
        rows(ellipse, ellipse._replace(x=0.0), Ellipse(3, 2, 9, 9)),
    )
    plane = np.empty(pixels.shape[:2], np.uint8)
    kernels.sobel.sobel(pixels, 0, 0, 100.0, 8, plane)
    expected, found = np.empty((3, 9)), np.empty((3, 9))
    kernels.sobel.histograms(plane, 0, 0, ellipses, Reading(lattice, PixelGrid(1, 1), 0), expected)
    kernels.sobel.histograms_at(pixels, ellipses, lattice, 0, 100.0, found)
    np.testing.assert_array_equal(found, expected)


@pytest.mark.parametrize("cells", [1, 3])
def test_quarter_turns(cells: int) -> None:
    """A target turned with its ellipse keeps its histogram, if that is turned too."""
    pixels = mosaic(5, 31, 31)
    where, left = Ellipse(13, 17, 9.2, 4.3, 0.3), Ellipse(17, 30 - 13, 9.2, 4.3, 0.3 - math.pi / 2)
    quarter = np.rot90(pixels).copy()
    for turned in (True, False):
        cue = Hog(cells=cells, rotation_normalized=turned, sampling=EveryPixel())
        model = cue.learn(frame(pixels), where)
        distance = cue.distances(model, frame(quarter), rows(left))[0]
        assert bool(distance < 1e-3) is turned


def test_bands_of_rows_leave_no_trace() -> None:
    pixels = mosaic(3, 3 * kernels.hog.BAND + 5, 20)
    strength, bins = np.empty(pixels.shape[:2], np.float32), np.empty(pixels.shape[:2], np.uint8)
    kernels.hog.gradients(pixels, 0, 0, SMOOTH, DERIVATIVE, strength, bins, 8)
    for row in (0, kernels.hog.BAND - 1, kernels.hog.BAND, 2 * kernels.hog.BAND, len(pixels) - 1):
        for column in (0, 7, 19):
            gx, gy = smooth_gradient(pixels, row, column)
            assert strength[row, column] == pytest.approx(math.hypot(gx, gy))
            angle = (bins[row, column] / 8 - 0.5) * 2 * math.pi
            assert strength[row, column] == 0 or (
                math.cos(angle - math.atan2(gy, gx)) > math.cos(math.pi / 8) - 1e-6
            )
