"""A damaged film: it opens, and has the frames that the command line has."""

from pathlib import Path

import pytest

from clips import spoil
from motes.cli import main
from motes.video import Film
from motes_studio.server import SOON
from studios import BOX, FRAMES, begin, film, looking, running

pytestmark = pytest.mark.slow


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    path = tmp_path / "films"
    path.mkdir()
    whole = film(path / "whole.mkv")
    spoil(whole, 20, 2).rename(path / "film.mkv")
    return path


def test_a_damaged_film_has_the_frames_of_the_command_line(folder: Path, tmp_path: Path) -> None:
    whole = Film(folder / "film.mkv")
    lost = FRAMES - len(whole.times)
    assert lost > 0
    with running(folder, tmp_path / "data") as client:
        session = begin(client)
        with looking(client, session) as page:
            assert page.session.film.frames == FRAMES
            number = page.drawn()
            page.do("set_keyframe", object=number, frame=35, region=BOX)
            page.do("track")
            page.until_left()
        for _ in range(2):  # it stays so
            with looking(client, session) as page:
                assert page.session.film.frames == FRAMES - lost
                assert page.session.film.problems == whole.report.problems
                item = page.item(number)
                assert [each.frame for each in item.keyframes] == [0, 35 - lost]
                assert (item.first, item.last) == (0, FRAMES - lost - 1)
                page.settle()
        rows = client.get(f"/api/sessions/{session}/export?format=csv&object={number}").content
        for index in (0, 19, FRAMES - lost - 1):
            answer = client.get(f"/api/sessions/{session}/frames/{index}.jpg")
            assert answer.status_code == 200
        with looking(client, session) as page:
            page.do("undo")
            page.until(lambda: len(page.item(number).keyframes) == 1)
    box = ",".join(map(str, BOX))
    words = ["track", str(folder / "film.mkv"), "--preset", "mean_shift", "--at", f"0={box}"]
    output = tmp_path / "rows.csv"
    assert main([*words, "--at", f"{35 - lost}={box}", "-o", str(output)]) == 0
    assert rows == output.read_bytes()


def test_damage_that_is_met_is_no_error(folder: Path, tmp_path: Path) -> None:
    """The page is told that an answer comes later, by the film's name without its folder."""
    with running(folder, tmp_path / "data") as client:
        answer = client.get(f"/api/sessions/{begin(client)}/frames/21.jpg")
    assert answer.status_code == SOON
    assert answer.json()["error"].startswith("film.mkv is damaged; it is read as a whole")
