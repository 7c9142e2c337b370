"""Two pictures of a film without overlap: passages, doors, and identities that are kept."""

from __future__ import annotations

import pytest

from motes.core.geometry import Box
from motes_lab.cli import main
from motes_lab.papers import handover, rooms_on_film
from motes_lab.papers.rooms_on_film import passages_of, rig

VIEWS = range(45), range(55, 100)


def test_a_passage_is_from_the_last_frame_here_to_the_first_there() -> None:
    truths = [{3: Box(x, 0, 8, 20)} for x in (20, 38, 43, 46, 50, 60, 70)]
    assert passages_of(truths, VIEWS) == [(3, 0, 2, 4)]  # a quarter of 8 pixels is enough
    assert passages_of(truths[::-1], VIEWS) == [(3, 1, 2, 4)]
    assert passages_of(truths[:4], VIEWS) == []


def test_one_who_is_in_both_pictures_has_not_passed() -> None:
    wide = [{1: Box(x, 0, 40, 20)} for x in (0, 30, 60)]
    assert passages_of(wide, VIEWS) == [(1, 0, 0, 2)]


def test_doors_are_at_the_strip() -> None:
    left, right = rig(VIEWS, 50, linked=True).camera
    assert left.place[0].box == pytest.approx((45 - 6.75, 0, 6.75, 50))
    assert right.place[0].box == pytest.approx((0, 0, 6.75, 50))
    assert len(rig(VIEWS, 50, linked=True).passage) == 1
    assert not rig(VIEWS, 50, linked=False).passage


@pytest.mark.slow
def test_an_identity_passes_with_the_link_alone() -> None:
    film = handover.rendered_film(6, frames=200, people=1)
    *_, result = rooms_on_film.rooms_on_film([film], 1)
    rows = {row[0].text: [cell.text for cell in row[1:3]] for row in result.tables[""].rows}
    assert rows["with handover"] == ["1", "1"]
    assert rows["without"] == ["1", "0"]


def test_pictures_are_apart_on_film_alone(capfd: pytest.CaptureFixture[str]) -> None:
    for line in (["--apart"], [".", "--apart", "--known"]):
        assert main(["experiment", "handover", *line]) == 2
        assert "--apart needs a dataset and goes without --known" in capfd.readouterr().err
