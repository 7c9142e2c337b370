"""The appearance rule (Nummiaro et al., equations 11 to 13), status and confidence."""

import math
from typing import Any

import numpy as np
import pytest
from hypothesis import given, strategies as st

from motes import Ellipse, Frame, Status
from motes.core.types import Floats
from motes.cues.color import Color, ColorModel
from motes.cues.sampling import EveryPixel
from motes.sot.filtering.appearance_rule import AppearanceRule, BackgroundStatistics, Calibration
from oracles import bhattacharyya, every_pixel, frame, mosaic

CUE = Color(sampling=EveryPixel())


RGB: Any = ("rgb", (8, 8, 8), "radial")


def likenesses(picture: Frame, region: Ellipse, model: ColorModel, step: int = 1) -> Floats:
    """Return rho of the region at every place (rows, columns), or at each `step`th, one by one."""
    return np.array(
        [
            [
                1 - bhattacharyya(every_pixel(picture.pixels, moved, *RGB), model.histogram) ** 2
                for x in range(0, picture.width, step)
                for moved in [region._replace(x=x, y=y)]
            ]
            for y in range(0, picture.height, step)
        ]
    )


@pytest.mark.parametrize("step", [1, 3])
def test_background_over_every_pixel(step: int) -> None:
    """Equations 11 and 12 by brute force."""
    background, target = frame(mosaic(1, 14, 19)), frame(mosaic(2, 14, 19))
    region = Ellipse(9, 6, 4.3, 3.1, 0.2)
    model = CUE.learn(target, region)
    rho = likenesses(background, region, model, step)
    found = AppearanceRule(max_positions=-(-14 * 19 // step**2)).background(
        CUE, model, background, region, target_in_frame=False
    )
    assert found.mean == pytest.approx(rho.mean(), abs=1e-9)
    assert found.deviation == pytest.approx(rho.std(), abs=1e-9)


def test_the_target_is_no_background() -> None:
    pixels = mosaic(1, 14, 25)
    region = Ellipse(7, 6, 2.5, 2.5)
    pixels[3:10, 4:11] = 77
    picture = frame(pixels)
    model = CUE.learn(picture, region)
    rows, columns = np.mgrid[:14, :25]
    beside = (abs(columns - 7) > 5) | (abs(rows - 6) > 5)
    rho = likenesses(picture, region, model)[beside]
    found = AppearanceRule().background(CUE, model, picture, region, target_in_frame=True)
    assert found.mean == pytest.approx(np.mean(rho))
    assert found.deviation == pytest.approx(np.std(rho))
    with_it = AppearanceRule().background(CUE, model, picture, region, target_in_frame=False)
    assert with_it.mean > found.mean


def test_a_target_as_large_as_the_frame_leaves_no_other_background() -> None:
    picture = frame(mosaic(3, 12, 12))
    region = Ellipse(5.5, 5.5, 6, 6)
    model = CUE.learn(picture, region)
    inside, outside = (
        AppearanceRule().background(CUE, model, picture, region, target_in_frame=there)
        for there in (True, False)
    )
    assert (inside.mean, inside.deviation) == (outside.mean, outside.deviation)


@pytest.mark.parametrize(
    ("margin", "background", "threshold"),
    [
        (0.0, BackgroundStatistics(0.3, 0.1), 0.5),  # equation 13
        (0.0, BackgroundStatistics(0.0, 0.0), 0.0),
        (0.0, BackgroundStatistics(0.8, 0.3), 0.9),
        # The margin asks for more where the background varies little.
        (0.7, BackgroundStatistics(0.2, 0.1), 0.2 + 0.7 * 0.8),
        (0.7, BackgroundStatistics(0.2, 0.32), 0.84),
        (0.7, BackgroundStatistics(0.9, 0.01), 0.9),
    ],
)
def test_threshold(margin: float, background: BackgroundStatistics, threshold: float) -> None:
    rule = AppearanceRule(deviations=2.0, margin=margin, max_threshold=0.9)
    assert rule.threshold(background) == pytest.approx(threshold)


def walk(
    rule: AppearanceRule, seen: str, status: Status = Status.TRACKING, *, known: bool = False
) -> str:
    """Return the statuses, by first letters, over frames in which the rule holds (1) or not."""
    against, out = 0, ""
    for letter in seen:
        status, against = rule.next_status(status, letter == "1", against, known=known)
        out += status.value[0]
    return out


def test_searching_tracking_lost_searching() -> None:
    rule = AppearanceRule(frames=3)
    assert walk(rule, "1001100100001101", Status.SEARCHING) == "ttttttttttlstttt"
    assert walk(rule, "0000", Status.SEARCHING) == "ssss"
    assert walk(rule, "0000000") == "ttlssss"
    assert walk(rule, "0001") == "ttlt"
    assert walk(rule, "00100100") == "tttttttt"
    assert walk(AppearanceRule(frames=1), "0010") == "lstl"


def test_a_known_target_is_found_after_several_frames() -> None:
    rule = AppearanceRule(frames=2, found_frames=3)
    assert walk(rule, "110111011100110111", Status.SEARCHING, known=True) == "sssssttttttlssssst"
    assert walk(rule, "1", Status.SEARCHING) == "t"
    once = AppearanceRule(frames=2, found_frames=1)
    assert walk(once, "1001", Status.SEARCHING, known=True) == "ttlt"


def test_a_particle_outside_the_frame_does_not_count() -> None:
    picture = frame(mosaic(3, 12, 16))
    centers = [(-6, -17), (-0.6, 5), (-0.5, 5), (15.4, 11.4), (15.5, 5), (5, 11.5), (8, 6)]
    ellipses = np.array([(*center, 20.0, 20.0, 0.0) for center in centers])
    distances = np.full(len(centers), 0.1)
    refused = AppearanceRule(in_frame=True).counted(distances, ellipses, picture)
    assert refused.tolist() == [1, 1, 0.1, 0.1, 1, 1, 0.1]
    np.testing.assert_array_equal(AppearanceRule().counted(distances, ellipses, picture), distances)


@given(st.text("01", max_size=60), st.integers(1, 6))
def test_lost_is_one_frame_and_comes_only_after_tracking(seen: str, frames: int) -> None:
    statuses = "t" + walk(AppearanceRule(frames=frames), seen)
    assert "ll" not in statuses
    assert "sl" not in statuses
    assert "ts" not in statuses
    for before, letter, status in zip(statuses, seen, statuses[1:], strict=False):
        if letter == "1":
            assert status == "t"
        elif before != "t":
            assert status == "s"


def test_a_tracked_target_stands_out_from_the_corners_of_its_box() -> None:
    rule = AppearanceRule(contrast=0.5, max_threshold=0.9)

    def holds(before: Status, rho: float, around: float, *, appears: bool) -> bool:
        return rule.holds(before, appears, rho, around, 0.0)

    assert holds(Status.TRACKING, 0.71, 0.4, appears=False)  # in other light
    assert not holds(Status.TRACKING, 0.69, 0.4, appears=True)
    assert not holds(Status.SEARCHING, 0.71, 0.4, appears=False)
    assert holds(Status.SEARCHING, 0.71, 0.4, appears=True)
    assert holds(Status.TRACKING, 0.91, 0.9, appears=False)  # in gray, all is alike
    printed = AppearanceRule()
    assert printed.holds(Status.TRACKING, True, 0.1, 0.9, 7.0)
    assert not printed.holds(Status.TRACKING, False, 0.9, 0.1, 0.0)
    agreed = AppearanceRule(spread=0.5)  # particles that agree on no place show no target
    assert agreed.holds(Status.TRACKING, True, 1.0, 0.0, 0.49)
    assert not agreed.holds(Status.TRACKING, True, 1.0, 0.0, 0.51)


def test_regions_beside_are_at_the_corners_of_the_box() -> None:
    picture, upright = frame(mosaic(3, 40, 60)), Ellipse(30, 20, 6, 3)
    around = AppearanceRule(contrast=0.5).regions(upright, picture)
    centers = [[30, 20], [24, 17], [36, 17], [24, 23], [36, 23]]
    np.testing.assert_allclose(around[:, :2], centers)
    assert (around[:, 2:] == upright[2:]).all()
    turned = AppearanceRule(contrast=0.5).regions(upright._replace(theta=math.pi / 2), picture)
    np.testing.assert_allclose(turned[1], [27, 14, 6, 3, math.pi / 2])
    corner = AppearanceRule(contrast=0.5).regions(Ellipse(1, 1, 6, 3), picture)
    np.testing.assert_allclose(corner[:, :2], [[1, 1], [7, 4]])
    assert AppearanceRule().regions(upright, picture).shape == (1, 5)


def test_the_confidence_falls_where_particles_spread() -> None:
    fit = Calibration(middle=0.4, width=0.1, spread=2.0)
    assert fit.probability(0.4) == fit.probability(0.4, 0.25) == 0.5
    # At twice the usual spread the odds are a quarter of e, a width nearer than the middle.
    assert fit.probability(0.3, 0.5) == pytest.approx(1 / (1 + 4 / math.e))
    assert 0.5 < fit.probability(0.4, 0.0) == fit.probability(0.4, 0.02) < 1
    near = Calibration(middle=0.4, width=0.1)
    assert near.probability(0.3, 0.1) == near.probability(0.3, 7.0) == pytest.approx(0.7310586)
