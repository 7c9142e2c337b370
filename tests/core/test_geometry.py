"""Ellipses, boxes, regions."""

import math
import re
from collections.abc import Sequence
from typing import Any

import numpy as np
import pytest
from hypothesis import given, strategies as st

from motes.core.errors import ConfigError
from motes.core.geometry import (
    Box,
    Ellipse,
    as_ellipse,
    check_angle,
    iou,
    of_corners,
    perhaps_meant,
    region_within,
)

numbers = st.floats(-500, 500)
sizes = st.floats(0.5, 300)
angles = st.floats(-7, 7)
ellipses = st.builds(Ellipse, numbers, numbers, sizes, sizes, angles)
boxes = st.builds(Box, numbers, numbers, sizes, sizes)


@given(ellipses)
def test_box_is_the_tightest_around_the_outline(ellipse: Ellipse) -> None:
    outline = ellipse.polygon(20000)
    box = ellipse.box
    low = outline.min(axis=0) + 0.5
    size = np.ptp(outline, axis=0)
    scale = max(ellipse.a, ellipse.b)
    np.testing.assert_allclose([box.x, box.y], low, atol=1e-6 * scale)
    np.testing.assert_allclose([box.width, box.height], size, atol=1e-6 * scale)


@given(ellipses)
def test_outline_lies_on_the_ellipse(ellipse: Ellipse) -> None:
    x, y = (ellipse.polygon() - [ellipse.x, ellipse.y]).T
    cos, sin = math.cos(ellipse.theta), math.sin(ellipse.theta)
    u, v = (x * cos + y * sin) / ellipse.a, (y * cos - x * sin) / ellipse.b
    np.testing.assert_allclose(u * u + v * v, 1, atol=1e-6)


def test_angles_run_from_x_towards_y() -> None:
    first = Ellipse(0, 0, 10, 1, math.pi / 2).polygon(4)[0]
    np.testing.assert_allclose(first, [0, 10], atol=1e-12)
    box = Ellipse(0, 0, 10, 1, math.pi / 6).polygon()
    assert np.cov(box.T)[0, 1] > 0  # to the right and down


@pytest.mark.parametrize(
    "region",
    [
        Box(4, 5, 10, 6),
        [4, 5, 10, 6],
        np.array([4, 5, 10, 6], np.float32),
        Ellipse(8.5, 7.5, 5, 3),
        (8.5, 7.5, 5, 3, 0),
    ],
)
def test_every_form_of_a_region(region: Any) -> None:
    assert as_ellipse(region) == Ellipse(8.5, 7.5, 5, 3, 0)


@pytest.mark.parametrize(
    ("region", "message"),
    [
        ((1, 2, 3, 4, 5, 6), "has 4 numbers.*got 6"),
        ((1, 2, 0, 4), "has no area"),
        ((math.inf, 2, 3, 4), "not finite"),
        ((1, 2, 3, 4, math.nan), "not finite"),
        (None, "A region is"),
        (np.zeros((4, 4)), "A region is"),
        ([10**400, 0, 5, 5], "A region is x,y,width,height"),  # beyond all floats
    ],
)
def test_no_regions(region: Any, message: str) -> None:
    with pytest.raises(ConfigError, match=message):
        as_ellipse(region)


@pytest.mark.parametrize(
    ("region", "message"),
    [
        ((200, 10, 10, 10), "center outside the frame of 100x80"),
        ((10, 90, 10, 10), "center outside"),
        ((0, 0, 101, 20), "larger than the frame"),
        ((0, 0, 20, 81), "larger than the frame"),
        ((10, 10, 20, 1.9), "less than two pixels"),
        ((50, 40, 0.5, 5, 1.0), "less than two pixels"),
        ((0.2, 0.4, 0.1, 0.1), "give pixels, not shares of the picture"),
        ((0.2, 0.4, 0.1, 0.1, 1.5), "give pixels, not shares of the picture"),
        ((0.2, 0.4, 1, 1.5), "choose a larger one"),
    ],
)
def test_regions_that_do_not_fit(region: tuple[float, ...], message: str) -> None:
    with pytest.raises(ConfigError, match=message):
        region_within(region, 100, 80)


@pytest.mark.parametrize(
    "region", [(0, 0, 100, 80), (-8, -8, 20, 20), (95, 75, 10, 10), (5, 5, 2, 2), (-1, -1, 2, 2)]
)
def test_regions_that_fit(region: tuple[float, ...]) -> None:
    assert region_within(region, 100, 80) == Ellipse.from_box(region)


whole = st.tuples(st.integers(0, 12), st.integers(0, 12), st.integers(0, 9), st.integers(0, 9))


@given(whole, whole)
def test_overlap_counts_pixels(
    first: tuple[int, int, int, int], second: tuple[int, int, int, int]
) -> None:
    masks = np.zeros((2, 24, 24), bool)
    for mask, (x, y, w, h) in zip(masks, (first, second), strict=True):
        mask[y : y + h, x : x + w] = True
    union = (masks[0] | masks[1]).sum()
    expected = (masks[0] & masks[1]).sum() / union if union else 0
    assert float(iou(first, second)) == pytest.approx(expected)


@given(boxes, boxes)
def test_overlap_is_symmetric_and_bounded(first: Box, second: Box) -> None:
    value = float(iou(first, second))
    assert 0 <= value <= 1 + 1e-9
    assert value == float(iou(second, first))
    assert float(iou(first, first)) == pytest.approx(1)


@pytest.mark.parametrize(
    ("region", "meant"),
    [
        ((60, 20, 90, 60), (60, 20, 30, 40)),  # leaves to the right
        (Ellipse.from_box((60, 20, 90, 60)), (60, 20, 30, 40)),
        ((60, 20, 30, 40), None),
        ((90, 20, 30, 40), None),  # leaves, and is left of its own x
        ((60, 20, 120, 60), None),  # leaves, and so do the corners
        (Ellipse(60, 20, 90, 60, 0.1), None),
    ],
)
def test_corners_that_were_given_as_a_box(
    region: Sequence[float], meant: tuple[float, ...] | None
) -> None:
    assert of_corners(region, 100, 80) == meant


@pytest.mark.parametrize(
    ("region", "meant"),
    [
        ((60, 20, 90, 60), "60,20,30,40 (x,y,width,height) if its numbers are corners x1,y1,x2,y2"),
        ((90, 20, 60, 60), "60,20,30,40 (x,y,width,height) if its numbers are corners x1,y1,x2,y2"),
        ((90, 60, 60, 20), "60,20,30,40 (x,y,width,height) if its numbers are corners x1,y1,x2,y2"),
        ((10, 20, 60, 50, 0.9), "10,20,60,50 (x,y,width,height) if its fifth number is a score"),
    ],
)
def test_a_refused_region_names_the_box_that_is_meant(region: Sequence[float], meant: str) -> None:
    with pytest.raises(ConfigError, match=rf"choose .*, or {re.escape(meant)}\.$"):
        region_within(region, 100, 80)


@pytest.mark.parametrize("region", [(0, 0, 1, 1), ["0", "0", "1", "1"]])
def test_shares_of_the_picture_are_refused(region: list[float]) -> None:
    """Also in text, as of a line that was split at its commas."""
    with pytest.raises(ConfigError, match="give pixels, not shares of the picture"):
        region_within(region, 100, 80)


def test_a_fifth_number_that_is_no_angle() -> None:
    with pytest.raises(ConfigError, match=r"begins with 40; .* 6\.28; a box has four numbers"):
        check_angle(40.0)


def test_a_score_that_was_given_as_an_angle() -> None:
    """As far as that can be known: the ellipse leaves the picture, and the box does not."""
    assert perhaps_meant((30, 30, 50, 40, 0.9), 100, 80) == (
        "30,30,50,40 (x,y,width,height) if its fifth number is a score"
    )
    assert not perhaps_meant((50, 40, 20, 10, 0.9), 100, 80)  # it is within the picture
    assert not perhaps_meant((80, 40, 30, 20, 0.9), 100, 80)  # the box leaves it, too
    assert not perhaps_meant((30, 30, 50, 40, -0.9), 100, 80)


@given(boxes)
def test_box_and_inscribed_ellipse_agree(box: Box) -> None:
    np.testing.assert_allclose(Ellipse.from_box(box).box, box, atol=1e-9)
