"""Objects that stand on a line, or on the edge of a zone, and tremble there."""

from __future__ import annotations

import math
from collections.abc import Iterable

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from msgspec.structs import replace

from motes.core.geometry import Ellipse
from motes.core.track import Status, Track
from motes.core.types import Floats
from motes.mot.analytics.events import EventCounter
from motes.mot.analytics.regions import Line, Regions, Zone

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


def noise(amplitude: float, seed: int, frames: int = 250) -> Floats:
    """Return places around the line, as far as an amplitude in heights."""
    return 500 + HIGH * amplitude * np.random.default_rng(seed).uniform(-1, 1, frames)


def swings(amplitude: float, period: float, frames: int = 250) -> Floats:
    """Return places that swing around the line, as far as an amplitude in heights."""
    return 500 + HIGH * amplitude * np.sin(2 * math.pi * np.arange(frames) / RATE / period)


@settings(max_examples=60, deadline=None)
@given(st.floats(0.01, 3), st.integers(0, 10**6), st.booleans())
def test_noise_of_any_size_is_one_crossing_at_most(size: float, seed: int, came: bool) -> None:
    """Whether it walks up to the line, or is found on it."""
    assert len(events([*UP[: len(UP) * came], *noise(size, seed)])) <= 1


@settings(max_examples=60, deadline=None)
@given(st.floats(0.01, 3), st.floats(0.1, 1))
def test_a_fast_swing_of_any_size_is_one_crossing_at_most(size: float, period: float) -> None:
    assert len(events([*UP, *swings(size, period)])) <= 1


@settings(max_examples=30, deadline=None)
@given(st.floats(0.01, 0.49), st.floats(0.1, 9))
def test_a_slow_swing_of_less_than_half_a_height_is_one_crossing(size: float, many: float) -> None:
    assert len(events([*UP, *swings(size, many)])) <= 1


@settings(max_examples=30, deadline=None)
@given(st.floats(0.01, 0.3), st.integers(0, 10**6))
def test_who_trembles_at_an_edge_enters_once(size: float, seed: int) -> None:
    assert events([*UP, *noise(size, seed)], ROOM) in ([], ["enters"])


@settings(max_examples=30, deadline=None)
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
