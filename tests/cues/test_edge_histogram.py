"""Edge histograms (Ng and Delp, sections 3.2 and 3.3) against plain second implementations."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from hypothesis import assume, example, given
from hypothesis import strategies as st
from numpy.typing import NDArray

from motes import kernels
from motes.core.geometry import Ellipse
from motes.cues.gradients import Edges
from motes.cues.sampling import Lattice, sunflower
from motes.kernels.structures import PixelGrid, Reading
from oracles import (
    MIDDLE,
    SHARES,
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
    sobel,
)

Floats = NDArray[np.float64]


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


# Histograms


@given(pictures, regions, st.sampled_from(sorted(SHARES)), st.sampled_from([8, 9, 36]))
@example(mosaic(1, 16, 16), Ellipse(8, 8, 6, 5, 0.0), "all", 8)
@example(mosaic(1, 16, 16), Ellipse(0, 15, 6, 5, 0.0), "half", 8)
@example(mosaic(1, 16, 16), Ellipse(9, 7, 500, 500, 0.1), "quarter", 9)
def test_pixels(pixels: Any, ellipse: Ellipse, share: str, count: int) -> None:
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
def test_lattice(pixels: Any, ellipse: Ellipse, points: int) -> None:
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


# Distances


def test_without_any_strong_edge() -> None:
    """Flat regions are alike, unlike those with edges, and unlike what lies outside the frame."""
    cue, flat = Edges(), edge((1, 0), 0)
    model = cue.learn(flat, MIDDLE)
    np.testing.assert_array_equal(model.histogram, [0] * 8 + [1])
    outside = MIDDLE._replace(x=90.0)
    np.testing.assert_array_equal(cue.distances(model, flat, rows(MIDDLE, outside)), [0, 1])
    np.testing.assert_array_equal(cue.distances(model, edge((1, 0)), rows(MIDDLE, outside)), 1)
    assert not cue.histograms(flat, rows(outside)).any()


# Planes


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
