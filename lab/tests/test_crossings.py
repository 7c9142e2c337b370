"""Counts beside the crossings that were found by eye."""

from pathlib import Path

import pytest

from motes_lab.cli import main
from motes_lab.papers.zhao_pei_figure10 import compare_crossings
from red_box import walk


def test_crossings_are_compared_one_to_one() -> None:
    compared = compare_crossings([10, 30, 60], [21, 22, 39, 90])
    assert compared.counted == [30]
    assert compared.missed == [10, 60]
    assert compared.false == [21, 39, 90] or compared.false == [21, 22, 90]
    assert compare_crossings([10, 20], [12, 28]).missed == []  # as many as can be
    assert compare_crossings([], [5]).false == [5]
    assert compare_crossings([5], []).missed == [5]


@pytest.fixture(scope="module")
def films(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return a folder with a film of a box that goes to the right over x = 80 in frame 33."""
    folder = tmp_path_factory.mktemp("films")
    walk(folder / "walk.mkv", frames=60, enters=11)
    return folder


@pytest.mark.slow
def test_a_film_is_counted(films: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Its second line has a crossing that is none, and its third one that is to the other side."""
    (films / "truth.toml").write_text(
        "[[clip]]\nfile = 'walk.mkv'\n[[clip.line]]\npoints = [80, 0, 80, 95]\nleft = [33]\n"
        "[[clip.line]]\npoints = [0, 20, 159, 20]\nright = [7]\n"
        "[[clip.line]]\npoints = [80, 0, 80, 95]\nright = [33]\n"
    )
    arguments = [str(films / "truth.toml"), str(films)]
    assert main(["experiment", "zhao-figure10", *arguments, "--out", str(films / "out")]) == 0
    lines = (films / "out" / "zhao-figure10.csv").read_text().splitlines()
    rows = [line.rsplit(",", 6)[1:5] for line in lines[1:]]
    assert rows == [
        ["1", "1", "0", "0"],
        ["1", "0", "1", "0"],
        ["1", "0", "1", "1"],
        ["3", "1", "2", "1"],
    ]


def test_a_truth_that_is_none_is_one_clear_line(
    films: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (films / "bad.toml").write_text("[[clip]]\nfile = 'walk.mkv'\n")
    assert main(["experiment", "zhao-figure10", str(films / "bad.toml"), str(films)]) != 0
    assert "line" in capsys.readouterr().err
