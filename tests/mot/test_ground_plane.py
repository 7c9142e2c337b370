"""The ground in metres."""

from __future__ import annotations

import math

import numpy as np
import pytest
from msgspec.structs import replace

from motes.core.errors import ConfigError
from motes.core.track import Status
from motes.mot.analytics.events import EventCounter
from motes.mot.analytics.ground_plane import Ground
from motes.mot.analytics.regions import Regions
from sightings import seen, told


def seen_by_a_camera(x: float, y: float) -> tuple[float, float]:
    """Return the pixel of a point on the ground: 5 m high, 30 degrees down, 500 pixels focal."""
    tilt, height, focal = math.radians(30), 5.0, 500.0
    depth = y * math.cos(tilt) + height * math.sin(tilt)
    down = height * math.cos(tilt) - y * math.sin(tilt)
    return 320 + focal * x / depth, 240 + focal * down / depth


GRID = [(float(x), float(y)) for x in (-2, 0, 3) for y in (4, 7, 15)]
POINTS = tuple((*seen_by_a_camera(*metres), *metres) for metres in GRID)


def test_points_of_a_camera() -> None:
    """Four of them say where all others are, and more say the same."""
    for points in (POINTS, (POINTS[0], POINTS[2], POINTS[6], POINTS[8])):
        ground = Ground(points=points)
        for x, y in [(0.5, 5.0), (-4.0, 30.0), (9.0, 2.0)]:
            assert ground.metres(seen_by_a_camera(x, y)) == pytest.approx((x, y))
        horizon = 240 - 500 * math.tan(math.radians(30))
        assert ground.metres((100, horizon - 1)) is None
        assert ground.metres((100, horizon + 1)) is not None


@pytest.mark.parametrize("factor", [1, -1])
def test_a_homography_is_taken_times_anything(factor: float) -> None:
    """OpenCV's have a 1 at the end; then w is negative on the ground below a horizon."""
    matrix = factor * np.array([[2, 0, 1], [0, 4, -2], [0, 0, 2]])
    ground = Ground(homography=matrix.tolist())
    assert ground.metres((10, 20)) == (10.5, 39)


def test_speeds_in_metres() -> None:
    """Ten pixels in a quarter of a second, at 20 pixels in a metre."""
    counting = EventCounter(Regions(ground=Ground(scale=20)))
    events = told(counting, *(seen(i, (10 * i, 40)) for i in range(5)))
    events += told(counting, seen(5, (100, 40)))
    assert events[0].metres_per_second is None
    (gone,) = told(counting, seen(6, (100, 40), Status.LOST))
    assert gone.speed is not None
    assert gone.speed > 0
    assert gone.metres_per_second == pytest.approx(gone.speed / 20)
    assert gone.fields()["metres_per_second"] == round(gone.speed / 20, 3)
    tiny = replace(gone, metres_per_second=1.23456789e-6)  # under a microscope
    assert tiny.fields()["metres_per_second"] == 1.2346e-6
    assert replace(gone, metres_per_second=1e-16).fields()["metres_per_second"] == 0


@pytest.mark.parametrize(
    ("values", "said"),
    [
        ({}, "exactly one of scale, homography and points"),
        ({"scale": 3, "points": POINTS}, "exactly one of"),
        ({"scale": 0}, "it takes number, 1e-09 to "),
        ({"homography": (1, 2, 3)}, r"homography\[0\]: got 1; it takes list of 3: number"),
        ({"homography": ((1, 2, 3), (2, 4, 6), (0, 0, 1))}, "onto a line"),
        ({"points": POINTS[:3]}, r"four points or more, each \[x, y, X, Y\], and has 3; add"),
        ({"points": [(i, i, i, 2 * i) for i in range(5)]}, "on a line"),
        ({"points": [(0, 0, 0, 0), (9, 9, 9, 0), (9, 0, 9, 9), (0, 9, 0, 9)]}, "horizon"),
    ],
)
def test_what_is_no_ground(values: dict[str, object], said: str) -> None:
    with pytest.raises(ConfigError, match=said):
        Ground(**values)  # type: ignore[arg-type]
