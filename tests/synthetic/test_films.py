"""The painted films: a street and a match."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from motes.synthetic.painted_film import PaintedFilm
from motes.synthetic.pitch import Pitch
from motes.synthetic.street import Street

FILMS = [Street, Pitch]


@pytest.mark.parametrize("film", FILMS)
def test_equal_seeds_give_equal_frames(film: Callable[[int], PaintedFilm]) -> None:
    (first, truths), (again, _) = film(3)[40], film(3)[40]
    assert (first.pixels == again.pixels).all()
    assert (first.pixels != film(4)[40][0].pixels).any()
    assert first.pixels.shape == (270, 480, 3)
    assert first.index == 40
    assert first.time == pytest.approx(1.6)
    assert truths == film(4)[40][1]  # the seed does not move what is followed
    assert len(film(3)) == 200


@pytest.mark.parametrize("film", FILMS)
def test_what_moves_is_in_the_boxes_of_the_truth(film: Callable[[int], PaintedFilm]) -> None:
    made = film(0)
    before, after = (made.picture(time).reduce(2) for time in (60, 60.5))
    moved = np.abs(np.asarray(after, int) - np.asarray(before)).sum(axis=2) > 60
    if film is Pitch:  # the camera moves all else
        moved[:90] = False
    covered = np.zeros_like(moved)
    for box in made.boxes(60):
        top, left = max(round(box.y) - 3, 0), max(round(box.x) - 4, 0)
        bottom, right = round(box.y + box.height) + 9, round(box.x + box.width) + 18  # shadows
        covered[top : max(bottom, 0), left : max(right, 0)] = True
    assert moved.sum() > 150
    assert (moved & ~covered).sum() < (0.02 if film is Street else 0.5) * moved.sum()


def test_a_car_is_hidden_behind_the_lorry_and_seen_again() -> None:
    street = Street()
    visible = [street.truths(index)[0].visible for index in range(len(street))]
    assert visible[30] == pytest.approx(1)
    assert min(visible[60:100]) < 0.2
    assert max(visible[100:130]) > 0.9
