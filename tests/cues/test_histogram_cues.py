"""What all cues that read histograms of an ellipse's pixels have in common."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from msgspec.structs import replace

from motes.core.geometry import Ellipse
from motes.cues.color import Color
from motes.cues.edge_histogram import Edges
from motes.cues.hog import Hog
from motes.cues.sampling import PROFILES, Checkerboard, EveryPixel, Lattice
from oracles import bhattacharyya, frame, mosaic

samplings = st.sampled_from(
    [EveryPixel(), Checkerboard(share="half"), Checkerboard(share="quarter"), Lattice(points=64)]
)
cues = (
    st.builds(
        Color,
        space=st.sampled_from(["rgb", "hsv", "hsv+v"]),
        bins=st.sampled_from([(8, 8, 4), (3, 2, 5)]),
        kernel=st.sampled_from(sorted(PROFILES)),
        sampling=samplings,
    )
    | st.builds(Edges, sampling=samplings)
    | st.builds(
        Hog,
        cells=st.integers(1, 3),
        bins=st.sampled_from([5, 8]),
        rotation_normalized=st.booleans(),
        sampling=samplings,
    )
)
pictures = st.builds(mosaic, st.integers(0, 99), st.integers(1, 16), st.integers(1, 16))
places, halves = st.floats(-6, 22), st.floats(0.3, 30)
regions = st.builds(Ellipse, places, places, halves, halves, st.floats(-4, 4))
OF_EDGES = pytest.mark.parametrize("kind", [Edges, Hog])


@given(pictures, st.lists(regions, min_size=1, max_size=4), regions, cues)
def test_distances(pixels: Any, candidates: list[Ellipse], target: Ellipse, cue: Any) -> None:
    """Over all bins: Nummiaro et al., equations 6 and 7; Ng and Delp, 20 and 21."""
    picture, where = frame(pixels), np.array(candidates)
    model = cue.learn(picture, target)
    found = cue.distances(model, picture, where)
    # Near 0 the distance is the root of what rounding leaves of 1 - rho.
    expected = [bhattacharyya(p, model.histogram) for p in cue.histograms(picture, where)]
    np.testing.assert_allclose(found**2, np.square(expected), atol=1e-12)
    assert ((found >= 0) & (found <= 1)).all()


@pytest.mark.parametrize("cue", [Color(), Edges(), Hog(cells=3)], ids=repr)
def test_what_a_model_learns_from_is_the_region_s_histogram(cue: Any) -> None:
    before, after = frame(mosaic(7, 30, 30)), frame(mosaic(8, 30, 30))
    ellipse = Ellipse(14, 15, 8, 6, 0.2)
    model = cue.learn(before, ellipse)
    dense = replace(cue, sampling=cue.sampling.dense)
    first, seen = (
        one.histograms(picture, np.array([ellipse]))[0]
        for one, picture in ((dense, before), (cue, after))
    )
    np.testing.assert_array_equal(model.histogram, first)
    np.testing.assert_array_equal(model.anchor, first)
    np.testing.assert_array_equal(cue.observe(model, after, ellipse), seen)
    assert (seen != first).any()
    assert cue.update_reading(model, after, ellipse) is model
    assert not cue.observe(model, after, ellipse._replace(x=200.0)).any()


@given(pictures, regions, st.sampled_from([Edges, Hog]))
def test_a_part_is_computed_as_in_the_whole(pixels: Any, ellipse: Ellipse, kind: Any) -> None:
    """Bit for bit: what is kept of a frame must not depend on who asked first."""
    cue, where = kind(sampling=EveryPixel()), np.array([ellipse])
    whole, part = frame(pixels), frame(pixels)
    cue.histograms(whole, np.array([Ellipse(8, 8, 99, 99)]))
    [plane] = whole.cache.values()
    assert plane.bins.shape == pixels.shape[:2]
    np.testing.assert_array_equal(cue.histograms(part, where), cue.histograms(whole, where))


@OF_EDGES
def test_large_regions_are_read_at_points_only(kind: Any) -> None:
    picture = frame(mosaic(0, 60, 80))
    where = np.array([Ellipse(40, 30, 39, 29)])  # 4,700 pixels; a point costs three or five of them
    kind().histograms(picture, where)
    assert picture.cache == {}
    kind(sampling=EveryPixel()).histograms(picture, where)
    assert len(picture.cache) == 1


@OF_EDGES
def test_a_plane_is_computed_once_and_only_where_ellipses_are(kind: Any) -> None:
    picture = frame(mosaic(0, 60, 80))
    cue = kind(sampling=Lattice(points=512))
    model = cue.learn(picture, Ellipse(40, 30, 20, 10))
    [plane] = picture.cache.values()
    assert (plane.column, plane.row, plane.bins.shape) == (20, 20, (21, 41))
    cue.distances(model, picture, np.array([Ellipse(35, 30, 8, 8)]))
    kind(kernel="uniform", sampling=Checkerboard()).learn(picture, Ellipse(45, 30, 8, 8))
    assert list(picture.cache.values()) == [plane]
    cue.distances(model, picture, np.array([Ellipse(60, 30, 8, 8)]))
    [moved] = picture.cache.values()
    assert moved is not plane
    kind(bins=12).learn(picture, Ellipse(60, 30, 8, 8))
    Edges(threshold=50).learn(picture, Ellipse(60, 30, 8, 8))
    assert len(picture.cache) == 3
