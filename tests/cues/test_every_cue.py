"""What all cues that compare histograms of pixels have in common."""

from __future__ import annotations

from typing import Any

import msgspec
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from motes.core.geometry import Ellipse
from motes.cues.color import Color
from motes.cues.gradients import Edges, Hog
from motes.cues.sampling import Checkerboard, EveryPixel, Lattice, Sampling
from motes.cues.structure_tensor import Orientation
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
on_planes = pytest.mark.parametrize("cue", ON_PLANES, ids=lambda cue: type(cue).__name__)
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


# Planes


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


@on_planes
def test_a_plane_is_computed_once_and_only_where_ellipses_are(cue: Any) -> None:
    picture = frame(mosaic(0, 60, 80))
    cue = read(cue, Lattice(points=512))
    model = cue.learn(picture, Ellipse(40, 30, 20, 10))
    [plane] = picture.cache.values()
    assert (plane.column, plane.row, plane.bins.shape) == (20, 20, (21, 41))
    cue.distances(model, picture, rows(Ellipse(35, 30, 8, 8)))
    other = msgspec.structs.replace(cue, kernel="uniform", sampling=Checkerboard())
    other.learn(picture, Ellipse(45, 30, 8, 8))
    assert list(picture.cache.values()) == [plane]
    cue.distances(model, picture, rows(Ellipse(60, 30, 8, 8)))
    [moved] = picture.cache.values()
    assert moved is not plane
    msgspec.structs.replace(cue, bins=12).learn(picture, Ellipse(60, 30, 8, 8))
    assert len(picture.cache) == 2
