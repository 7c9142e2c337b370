"""Who crosses a line once: who stands there and trembles, and vehicles seen in parts."""

import math
from collections.abc import Iterable, Sequence

import numpy as np
import pytest
from hypothesis import given, strategies as st
from msgspec.structs import replace

from motes import Box, Ellipse, Line, Regions, Status, Track, Zone
from motes.core.types import Floats
from motes.mot.analytics.event_counter import PART, EventCounter
from motes.mot.analytics.parts import FEW, usual_of

HIGH, WIDE, RATE = 40, 16, 25
STEP = 2.4
"""Pixels a frame of somebody who walks: one and a half heights a second."""
UP = np.arange(400, 500, STEP)
"""The way to the line at 500."""
PLACES = Regions((Line((500, 0, 500, 999), label=("on", "back")),))
ROOM = Regions(zone=(Zone((500, 0, 900, 0, 900, 999, 500, 999)),))


def events(
    feet: Iterable[float], places: Regions = PLACES, scale: float = 1.0, wide: float = WIDE
) -> list[str]:
    """Return the directions of crossings, or kinds of events, of a foot at places along x."""
    counter, found = EventCounter(places), []
    for i, x in enumerate(feet):
        ellipse = Ellipse(x, 500 - scale * HIGH / 2, scale * wide / 2, scale * HIGH / 2)
        track = Track(i, i / RATE, ellipse, np.eye(5), 1.0, Status.TRACKING, 0.0, 1.0)
        found += counter.update([replace(track, identity=1, detected=True)])
    found += counter.finish()
    return [each.direction or each.event for each in found if each.place]


def noise(amplitude: float, seed: int, frames: int = 75) -> Floats:
    """Return places around the line, as far as an amplitude in heights."""
    return 500 + HIGH * amplitude * np.random.default_rng(seed).uniform(-1, 1, frames)


def swings(amplitude: float, period: float, frames: int = 125) -> Floats:
    """Return places that swing around the line, as far as an amplitude in heights."""
    return 500 + HIGH * amplitude * np.sin(2 * math.pi * np.arange(frames) / RATE / period)


@given(st.floats(0.01, 3), st.integers(0, 10**6), st.booleans())
def test_noise_of_any_size_is_one_crossing_at_most(size: float, seed: int, came: bool) -> None:
    """Whether it walks up to the line, or is found on it."""
    assert len(events([*UP[: len(UP) * came], *noise(size, seed)])) <= 1


@given(st.floats(0.01, 3), st.floats(0.1, 1))
def test_a_fast_swing_of_any_size_is_one_crossing_at_most(size: float, period: float) -> None:
    assert len(events([*UP, *swings(size, period)])) <= 1


@given(st.floats(0.01, 0.49), st.floats(0.1, 9))
def test_a_slow_swing_of_less_than_half_a_height_is_one_crossing(size: float, many: float) -> None:
    assert len(events([*UP, *swings(size, many)])) <= 1


@given(st.floats(0.01, 0.3), st.integers(0, 10**6))
def test_who_trembles_at_an_edge_enters_once(size: float, seed: int) -> None:
    assert events([*UP, *noise(size, seed)], ROOM) in ([], ["enters"])


@given(st.floats(0, 0.1), st.integers(0, 10**6), st.floats(1.2, 4))
def test_who_goes_and_comes_back_counts_twice(size: float, seed: int, turn: float) -> None:
    """Turning round from 1.2 heights beyond on, after half a second there."""
    on = np.arange(500, 500 + turn * HIGH, STEP)
    way = np.concatenate([UP, on, np.full(13, on[-1]), on[::-1], UP[::-1]])
    assert events(way + noise(size, seed, len(way)) - 500) == ["on", "back"]


@pytest.mark.parametrize("places", [PLACES, ROOM])
def test_a_car_that_drives_to_and_fro_upon_a_line_counts_once(places: Regions) -> None:
    """It is longer than high, and backs by a third of its length."""
    stops = np.repeat([510.0, 478.0], 25)
    found = events([*UP, *stops, *np.arange(478, 600, STEP)], places, wide=90)
    assert found == [{PLACES: "on", ROOM: "enters"}[places]]


@pytest.mark.parametrize("pixels", [0.1, 0.3, 1.0, 8.0])
def test_who_goes_slowly_or_fast_counts_once(pixels: float) -> None:
    assert events(np.arange(480 - 5 * pixels, 520 + 13 * pixels, pixels)) == ["on"]


def test_a_small_ball_that_flies_past_counts() -> None:
    """It is 4 pixels high, and goes 10 a frame; it bounces where the picture ends."""
    way = [*range(435, 700, 10)]
    assert events(way[:12], scale=0.1) == ["on"]
    assert events([*way, *way[::-1]], scale=0.1) == ["on", "back"]


def test_who_trembles_and_goes_on_counts_once() -> None:
    for seed in range(20):
        tremble = noise(0.12, seed)
        assert events([*UP, *tremble, *np.arange(500, 600, STEP)]) == ["on"]


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


def test_who_trembles_and_turns_back_has_gone_nowhere() -> None:
    """What is counted on is counted back."""
    for seed in range(20):
        found = events([*UP, *noise(0.12, seed), *UP[::-1]])
        assert found in ([], ["on", "back"])


def test_a_usual_shape_is_known_from_a_few_on() -> None:
    shapes = [1.0, 2.0, 3.0, 4.0, 5.0, 6.0][:FEW]
    assert usual_of(shapes[1:]) is None
    assert usual_of(shapes) == pytest.approx(1 + 0.8 * (FEW - 1))
