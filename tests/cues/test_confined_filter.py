"""The filter that is confined to the target, compared with its equations in plain numpy."""

import math
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from motes import Ellipse, Frame, kernels
from motes.cues.confined_filter import REACH, ConfinedFilter, ConfinedModel

FILTER = ConfinedFilter()
TARGET = Ellipse(120.0, 90.0, 16.0, 20.0, 0.0)


def scene(seed: int = 0, height: int = 180, width: int = 240) -> NDArray[np.uint8]:
    """Return a random texture."""
    rng = np.random.default_rng(seed)
    coarse = rng.integers(0, 255, (height // 6 + 1, width // 6 + 1, 3), np.uint8)
    return coarse.repeat(6, axis=0).repeat(6, axis=1)[:height, :width]


def moved(x: int, y: int) -> Frame:
    """Return the scene with its target moved over a background that stays."""
    picture, target = scene(1), scene(2, 41, 33)
    left, top = round(TARGET.x) - 16 + x, round(TARGET.y) - 20 + y
    picture[top : top + 41, left : left + 33] = target
    return Frame(0, 0.0, picture)


def first() -> ConfinedModel:
    return FILTER.learn(moved(0, 0), TARGET)


@pytest.mark.parametrize("shift", [(0, 0), (5, -3), (-30, 12), (40, 25)])
def test_it_sees_the_target_where_it_has_moved(shift: tuple[int, int]) -> None:
    view = FILTER.view(first(), moved(*shift), TARGET)
    peak = view.peak()
    assert peak[:2] == pytest.approx((TARGET.x + shift[0], TARGET.y + shift[1]), abs=1.5)
    assert view.near(peak) > 0.5


def test_the_response_is_relative_to_the_first_frames() -> None:
    model = first()
    response = FILTER.view(model, moved(0, 0), TARGET).near(TARGET)
    assert response == pytest.approx(1 / 0.7, rel=1e-3)
    for _ in range(4):
        frame = moved(0, 0)
        model = FILTER.updated(model, frame, FILTER.view(model, frame, TARGET), TARGET)
    assert model.seen == 4
    response = FILTER.view(model, moved(0, 0), TARGET).near(TARGET)
    assert response == pytest.approx(1.0, abs=0.2)


def test_the_target_is_found_in_both_looks_that_were_learned() -> None:
    """Also where they have nothing in common but their place."""
    pictures = [scene(1), scene(1)]
    for seed, picture in enumerate(pictures, start=2):
        picture[70:110, 104:136] = scene(seed, 40, 32)
    one, two = (Frame(0, 0.0, picture) for picture in pictures)
    both = FILTER.learn_also(FILTER.learn(one, TARGET), two, TARGET)
    for frame in (one, two):
        peak = FILTER.view(both, frame, TARGET).peak()
        assert peak[:2] == pytest.approx(TARGET[:2], abs=1.5)


def test_a_place_outside_of_the_window_has_no_response() -> None:
    view = FILTER.view(first(), moved(0, 0), TARGET)
    far = TARGET._replace(x=TARGET.x + 3 * REACH * TARGET.side)
    assert view.near(far) == 0
    assert not view.covers(far)


def test_it_is_confined_to_the_target() -> None:
    """What lies around the target changes the response little."""
    model = first()
    other = moved(0, 0).pixels.copy()
    background = scene(5)
    box = np.s_[70:111, 104:137]
    background[box] = other[box]
    response = FILTER.view(model, Frame(0, 0.0, background), TARGET).near(TARGET)
    same = FILTER.view(model, moved(0, 0), TARGET).near(TARGET)
    assert response > 0.5 * same


def test_learning_from_a_window_beside_the_target_equals_learning_at_it() -> None:
    model, frame = first(), moved(6, -4)
    target = TARGET._replace(x=TARGET.x + 6, y=TARGET.y - 4)
    beside, at = (
        FILTER.updated(model, frame, FILTER.view(model, frame, place), target)
        for place in (TARGET, target)
    )
    for learned in (beside, at):
        view = FILTER.view(learned, frame, target)
        assert view.peak()[:2] == pytest.approx(target[:2], abs=1.5)
        assert view.near(target) > 0.5


Complexes = NDArray[np.complexfloating[Any, Any]]


def solved(x: Complexes, label: Any, target: Complexes, both: float, count: int) -> Any:
    """Return the minimum at one frequency, by a system of linear equations."""
    left = np.outer(x, x.conj()) / count + both * np.eye(len(x))
    return np.linalg.solve(left, x * label / count + target)


@pytest.mark.parametrize(("penalty", "inertia"), [(1.0, 0.0), (0.1, 15.0)])
def test_the_kernel_solves_the_equations(penalty: float, inertia: float) -> None:
    rng = np.random.default_rng(3)
    n, shape = 6, (5, 6, 4)

    def random(*size: int) -> NDArray[np.complex64]:
        return (rng.normal(size=size) + 1j * rng.normal(size=size)).astype(np.complex64)

    spectra, before, copied, multiplier = (random(*shape) for _ in range(4))
    label, out = random(6, 4), np.empty(shape, np.complex64)
    kernels.fourier_ridge.solve(spectra, label, before, copied, multiplier, penalty, inertia, out)
    for i, j in np.ndindex(6, 4):
        pull = penalty * copied[:, i, j] - multiplier[:, i, j] + inertia * before[:, i, j]
        expected = solved(spectra[:, i, j], label[i, j], pull, penalty + inertia, n * n)
        np.testing.assert_allclose(out[:, i, j], expected, rtol=2e-4, atol=2e-4)


def test_a_window_serves_for_places_near_by_of_about_its_size_and_angle() -> None:
    view = FILTER.view(first(), moved(0, 0), TARGET)
    assert view.covers(TARGET._replace(x=TARGET.x + TARGET.side))
    assert view.covers(TARGET._replace(a=1.05 * TARGET.a, b=1.05 * TARGET.b))
    assert not view.covers(TARGET._replace(x=TARGET.x + 2 * TARGET.side))
    assert not view.covers(TARGET._replace(a=1.2 * TARGET.a, b=1.2 * TARGET.b))
    assert not view.covers(TARGET._replace(theta=0.25))


def test_places_and_offsets_in_a_turned_window() -> None:
    turned = TARGET._replace(theta=0.5)
    view = FILTER.view(first(), moved(0, 0), turned)
    across, down = 3.0, -2.0
    step = view.pixels * 4
    x = turned.x + step * (math.cos(0.5) * across - math.sin(0.5) * down)
    y = turned.y + step * (math.sin(0.5) * across + math.cos(0.5) * down)
    assert view.offset(turned._replace(x=x, y=y)) == pytest.approx((across, down))
