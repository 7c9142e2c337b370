"""Color histograms and distances (Nummiaro et al., section III) against plain second ones."""

import math
from typing import Any, Literal

import numpy as np
import pytest
from hypothesis import assume, example, given, strategies as st
from numpy.typing import NDArray

from motes import Ellipse, kernels
from motes.cues.color import Color
from motes.cues.sampling import EveryPixel, Lattice, Profile, sunflower
from motes.kernels.structures import ColorBins
from oracles import (
    SHARES,
    Bins,
    between_pixels,
    bin_image,
    bin_of,
    every_pixel,
    frame,
    mosaic,
    on_a_border,
    on_lattice,
    radii,
    wide_regions,
)

Space = Literal["rgb", "hsv", "hsv+v"]
RGB8: Bins = (8, 8, 8)
HSV8: Bins = (8, 8, 4)

spaces = st.sampled_from(
    [("rgb", RGB8), ("hsv", HSV8), ("rgb", (3, 5, 1)), ("hsv", (10, 7, 6)), ("hsv+v", RGB8)]
)
profiles = st.sampled_from(["radial", "epanechnikov", "uniform", "gaussian"])
pictures = st.builds(mosaic, st.integers(0, 99), st.integers(1, 24), st.integers(1, 24))


@pytest.mark.parametrize("bins", [(8, 8, 4), (10, 10, 10), (7, 13, 61), (64, 64, 64)])
def test_hsv_bins_are_exact(bins: tuple[int, int, int]) -> None:
    """Quotients in single precision against whole numbers, over a grid of 700,000 colors."""
    levels = np.append(np.arange(0, 255, 3), [127, 254, 255])
    r, g, b = (part.ravel() for part in np.meshgrid(levels, levels, levels))
    found = (r + 256 * g + 65536 * b).astype(np.uint32)
    kernels.color.to_bins(found, ColorBins(kernels.color.HSV, *bins))
    high = np.maximum(np.maximum(r, g), b)
    spread = high - np.minimum(np.minimum(r, g), b)
    hue = np.select(
        [spread == 0, (high == r) & (g >= b), high == r, high == g],
        [0 * r, g - b, 6 * spread + g - b, 2 * spread + b - r],
        4 * spread + r - g,
    )
    i0 = hue * bins[0] // np.maximum(6 * spread, 1)
    i1 = np.minimum(spread * bins[1] // np.maximum(high, 1), bins[1] - 1)
    expected = (i0 * bins[1] + i1) * bins[2] + (high * bins[2] >> 8)
    np.testing.assert_array_equal(found, expected)


def bins_of(colors: Any, space: Space, bins: Bins) -> NDArray[np.intp]:
    """Return the bin of each color (n, 3): where a region of that one pixel has all its weight."""
    row = frame(np.array(colors, np.uint8)[None])
    pixels = np.zeros((row.width, 5))
    pixels[:, 0], pixels[:, 2:4] = np.arange(row.width), 0.5
    histograms = Color(space=space, bins=bins, sampling=EveryPixel()).histograms(row, pixels)
    assert (histograms.max(axis=1) == 1).all()
    numbers: NDArray[np.intp] = histograms.argmax(axis=1)
    return numbers


colors = st.lists(st.tuples(*[st.integers(0, 255)] * 3), min_size=1, max_size=30)
counts = st.tuples(*[st.integers(1, 64)] * 3)


@given(colors, counts, st.sampled_from(["rgb", "hsv", "hsv+v"]))
def test_bins_are_exact(colors: list[tuple[int, int, int]], bins: Bins, space: Any) -> None:
    expected = [bin_of(*color, space, bins) for color in colors]
    np.testing.assert_array_equal(bins_of(colors, space, bins), expected)


@pytest.mark.parametrize("share", SHARES)
@given(pictures, wide_regions, spaces, profiles)
@example(mosaic(1, 20, 20), Ellipse(10, 10, 5, 5, 0.0), ("rgb", RGB8), "radial")
@example(mosaic(1, 20, 20), Ellipse(9, 10, 5, 3, 0.0), ("hsv", HSV8), "radial")
@example(mosaic(1, 20, 20), Ellipse(0, 0, 6, 2, 0.0), ("hsv", HSV8), "epanechnikov")
@example(mosaic(1, 20, 20), Ellipse(19, 19, 500, 500, 0.3), ("rgb", RGB8), "radial")
@example(mosaic(1, 20, 20), Ellipse(40, 10, 5, 5, 0.3), ("rgb", RGB8), "radial")
@example(mosaic(1, 20, 20), Ellipse(7, 7, 0.5, 0.5, 0.0), ("rgb", RGB8), "radial")
def test_pixels(share: str, pixels: Any, ellipse: Ellipse, space: Any, profile: Any) -> None:
    """Equations 2 to 4; of Ng and Delp's parts, figure 2, the pixels are the image's."""
    assume(ellipse.theta == 0 or not on_a_border(pixels.shape, ellipse))
    cue = Color(space=space[0], bins=space[1], kernel=profile, sampling=SHARES[share])
    found = cue.histograms(frame(pixels), np.array([ellipse]))[0]
    expected = every_pixel(pixels, ellipse, space[0], space[1], profile, share)
    np.testing.assert_allclose(found, expected, atol=1e-9)
    assert found.sum() == pytest.approx(1) or not found.any()


@given(pictures, wide_regions, spaces, profiles, st.sampled_from([8, 64, 256]))
@example(mosaic(1, 20, 20), Ellipse(-0.5, -0.5, 9, 4, 0.0), ("rgb", RGB8), "radial", 256)
@example(mosaic(1, 20, 20), Ellipse(19.5, 19.5, 9, 4, 0.5), ("rgb", RGB8), "radial", 256)
@example(mosaic(1, 20, 20), Ellipse(90, 10, 9, 4, 0.5), ("rgb", RGB8), "radial", 256)
def test_lattice(pixels: Any, ellipse: Ellipse, space: Any, profile: Any, points: int) -> None:
    lattice = sunflower(points)
    assume(not between_pixels(ellipse, lattice))
    cue = Color(space=space[0], bins=space[1], kernel=profile, sampling=Lattice(points=points))
    found = cue.histograms(frame(pixels), np.array([ellipse]))[0]
    expected = on_lattice(pixels, ellipse, lattice, space[0], space[1], profile)
    np.testing.assert_allclose(found, expected, atol=1e-6)  # weights are single precision


@pytest.mark.parametrize("profile", ["radial", "epanechnikov", "uniform", "gaussian"])
def test_more_points_approach_every_pixel(profile: Profile) -> None:
    smooth = np.indices((200, 200)).sum(axis=0)
    pixels = np.stack([smooth // 2, 255 - smooth // 2, smooth // 3], axis=2).astype(np.uint8)
    ellipse = np.array([[97.3, 104.1, 80, 52, 0.6]])
    whole = Color(kernel=profile, sampling=EveryPixel()).histograms(frame(pixels), ellipse)
    errors = []
    for points in (32, 512, 8192):
        cue = Color(kernel=profile, sampling=Lattice(points=points))
        errors.append(np.abs(cue.histograms(frame(pixels), ellipse) - whole).sum())
    assert errors[0] > 3 * errors[1] > 9 * errors[2]
    assert errors[2] < 0.01


@given(st.integers(0, 50), wide_regions)
@example(3, Ellipse(12, 12, 7, 5, 0.0))
def test_the_mean_shift_vector(seed: int, ellipse: Ellipse) -> None:
    """Comaniciu et al. 2000, equations 10 and 11, pixel by pixel."""
    picture, past = frame(mosaic(seed, 24, 24)), frame(mosaic(seed, 24, 24)[::-1].copy())
    assume(ellipse.theta == 0 or not on_a_border((24, 24), ellipse))
    cue = Color(kernel="epanechnikov", sampling=EveryPixel())
    model = cue.learn(past, Ellipse(11, 13, 8, 5, 0.3))
    p = every_pixel(picture.pixels, ellipse, "rgb", RGB8, "epanechnikov")
    bins = bin_image(picture.pixels, "rgb", RGB8)
    inside = radii((24, 24), ellipse)[1] < 1
    total, x, y = 0.0, 0.0, 0.0
    for row, column in zip(*np.nonzero(inside), strict=True):
        u = bins[row, column]
        weight = math.sqrt(model.histogram[u] / p[u]) if p[u] > 0 else 0.0
        total, x, y = total + weight, x + weight * column, y + weight * row
    expected = (x / total, y / total) if total > 0 else (ellipse.x, ellipse.y)
    np.testing.assert_allclose(cue.shift(model, picture, ellipse), expected, atol=1e-7)


@pytest.mark.parametrize(
    "values",
    [
        (10, 10, 1e5, 1e5, 0), (10, 10, 1e9, 5, 0.3), (1e9, 3, 1e9, 4, 0), (5, 5, 1e18, 1e18, 0.2),
        (-3e9, 3, 3e9 + 20, 4, 0), (5, 5, 1e200, 1, 0), (1e300, 5, 8, 8, 0), (9, np.inf, 8, 8, 0),
    ],
)  # fmt: skip
def test_absurd_ellipses_read_nothing_that_is_not_there(values: tuple[float, ...]) -> None:
    pixels = mosaic(4, 48, 64)
    for cue in (Color(), Color(space="hsv", bins=HSV8, kernel="uniform")):
        total = cue.histograms(frame(pixels), np.array([values], float)).sum()
        assert total == 0 or total == pytest.approx(1)
