"""Vehicles that are seen in parts count once at a line; what only follows another counts itself."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pytest
from msgspec.structs import replace

from motes.core.geometry import Box, Ellipse
from motes.core.track import Status, Track
from motes.mot.analytics.events import PART, EventCounter
from motes.mot.analytics.regions import Line, Regions

Seen = tuple[float, Box]
"""How far along its way an object is in frame 0, and its box there, from that place on."""
CAR = Box(0, 200, 100, 36)


def counted(objects: Sequence[Seen], speeds: Sequence[float] | None = None) -> tuple[int, int]:
    """Return how many crossings count at x = 300, and how many parts are left out.

    All go to the right, 5 pixels a frame, 25 frames a second.
    """
    speeds = speeds or [5.0] * len(objects)
    counter, crossed = EventCounter(Regions((Line((300, 0, 300, 999)),))), 0
    for i in range(800):
        tracks = []
        for n, ((start, box), speed) in enumerate(zip(objects, speeds, strict=True), start=1):
            x = start + speed * i
            if -100 < x < 700:
                ellipse = Ellipse.from_box(box._replace(x=x))
                track = Track(i, i / 25, ellipse, np.eye(5), 1.0, Status.TRACKING, 0.0, 1.0)
                tracks.append(replace(track, identity=n, detected=True))
        crossed += sum(each.event == "crosses" for each in counter.update(tracks, i / 25))
    crossed += sum(each.event == "crosses" for each in counter.finish())
    return crossed, counter.left_out["line 1", PART]


def traffic(many: int = 4) -> list[Seen]:
    """Return cars far apart, which show what is usual."""
    return [(-300.0 * n, CAR) for n in range(many)]


def columns(start: float, *parts: tuple[float, float], box: Box = CAR) -> list[Seen]:
    """Return the parts of a car, from and to shares of its length."""
    return [
        (start + box.width * low, box._replace(width=box.width * (high - low)))
        for low, high in parts
    ]


THREE = (0, 0.3), (0.4, 0.65), (0.75, 1)
TWO = (0, 0.45), (0.58, 1)


@pytest.mark.parametrize("parts", [TWO, THREE])
@pytest.mark.parametrize("scale", [1.0, 0.6])
def test_a_car_in_columns_counts_once(parts: Sequence[tuple[float, float]], scale: float) -> None:
    """Also in another lane, where cars are smaller."""
    small = Box(0, 100, 100 * scale, 36 * scale)
    dark = columns(-1500, *parts, box=small)
    assert counted([*traffic(), *dark]) == (5, len(parts) - 1)


def test_cars_that_nearly_touch_count_each() -> None:
    assert counted([*traffic(), (-1500, CAR), (-1605, CAR)]) == (6, 0)


def test_parts_behind_a_whole_car_are_one() -> None:
    assert counted([*traffic(), (-1395, CAR), *columns(-1500, *TWO)]) == (6, 1)


def test_who_drives_otherwise_is_no_part() -> None:
    """It overtakes: together they look like a car only while they pass the line."""
    dark = columns(-1500, *TWO)
    ways = [5.0] * 5 + [3.5]
    start = 300 - 3.5 / 5 * (300 - dark[1][0])
    assert counted([*traffic(), dark[0], (start, dark[1][1])], ways) == (6, 0)


@pytest.mark.parametrize("apart", [(0, 30), (30, 0), (16, 6)])
def test_people_who_walk_together_count_each(apart: tuple[float, float]) -> None:
    """One behind the other, abreast, and both, where cars are usual or people are."""
    person = Box(0, 200, 24, 70)
    other = person._replace(y=200 + apart[1])
    for usual in (traffic(), [(-300.0 * n, person) for n in range(4)]):
        assert counted([*usual, (-1500, person), (-1500 - apart[0], other)]) == (6, 0)


def test_before_a_shape_is_usual_all_count() -> None:
    assert counted([*columns(-100, *TWO), *traffic(1)]) == (3, 0)
