"""motes demo: all files are there and hold what they should."""

import html
import json
import math
import re
from contextlib import redirect_stderr, redirect_stdout
from io import StringIO
from itertools import islice
from pathlib import Path

import pytest

from clips import write_film
from commands import read_csv
from motes.cli.demo import FILES, PAGE, STORIES, demo, films
from motes.core.errors import ConfigError, FormatError
from motes.core.track import COLUMNS
from motes.rows.schema import NUMBERS

FRAMES = 6
NAMES = [story.name for story in STORIES]


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, str, str]:
    """Make a demo; return its folder, standard output and standard error."""
    out = tmp_path_factory.mktemp("out") / "[red]" / "demo"
    with redirect_stdout(StringIO()) as said, redirect_stderr(StringIO()) as errors:
        assert demo(out=out, frames=FRAMES) == 0
    return out, said.getvalue(), errors.getvalue()


@pytest.fixture(scope="module")
def folder(made: tuple[Path, str, str]) -> Path:
    return made[0]


@pytest.mark.slow
def test_it_writes_all_files_and_no_others(folder: Path) -> None:
    assert sorted(path.name for path in folder.iterdir()) == sorted(FILES)


@pytest.mark.slow
def test_the_films_do_not_depend_on_the_number_of_cores(
    folder: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("MOTES_THREADS", "1")
    write_film(tmp_path / "street.mp4", islice(films()["street"](seed=0), FRAMES))
    assert (tmp_path / "street.mp4").read_bytes() == (folder / "street.mp4").read_bytes()


@pytest.mark.slow
@pytest.mark.parametrize("name", NAMES)
def test_the_rows_are_complete_and_near_the_truth(folder: Path, name: str) -> None:
    found = read_csv(folder / f"{name}.csv")
    truths = [objects[0].ellipse for _, objects in islice(films()[name](seed=0), FRAMES)]
    assert tuple(found[0]) == COLUMNS
    assert [int(row["frame"]) for row in found] == list(range(FRAMES))
    assert {row["status"] for row in found} == {"tracking"}
    for row, truth in zip(found, truths, strict=True):
        numbers = [float(row[column]) for column in NUMBERS if column in COLUMNS[:-1]]
        assert all(math.isfinite(number) for number in numbers)
        assert math.dist((float(row["x"]), float(row["y"])), truth[:2]) < 6
        assert abs(float(row["theta"]) - truth.theta) < 0.15  # the ellipse turns with the beetle


@pytest.mark.slow
def test_the_page_shows_all_films_and_every_frame_of_the_status(folder: Path) -> None:
    page = (folder / PAGE).read_text()
    assert re.findall('src="([^"]+)"', page) == [
        "beetle-tracked.mp4", "street-tracked.mp4", "street-counted.mp4", "player-tracked.mp4",
    ]  # fmt: skip
    shown = [json.loads(html.unescape(text)) for text in re.findall('data-states="([^"]+)"', page)]
    for story, states in zip(STORIES, shown, strict=True):
        assert story.title in page
        found = read_csv(folder / f"{story.name}.csv")
        assert [state for state, _ in states] == [row["status"] for row in found]
        confidences = [float(row["confidence"]) for row in found]
        assert [confidence for _, confidence in states] == pytest.approx(confidences, abs=0.006)
    assert "motes watch counted 0 of 0 cars" in page
    assert "$" not in page.replace("${", "")


def test_any_file_there_is_enough_to_refuse_before_any_work(tmp_path: Path) -> None:
    for name in FILES:
        path = tmp_path / name
        path.write_text("mine")
        with pytest.raises(FormatError, match=re.escape(name)):
            demo(out=tmp_path, frames=1)
        assert list(tmp_path.iterdir()) == [path]
        assert path.read_text() == "mine"
        path.unlink()


def test_wrong_arguments_are_refused(tmp_path: Path) -> None:
    with pytest.raises(ConfigError, match="give 1 or more"):
        demo(out=tmp_path / "a", frames=0)
    with pytest.raises(ConfigError, match="give 0 or more"):
        demo(out=tmp_path / "a", seed=-1)
    assert not (tmp_path / "a").exists()
    (tmp_path / "file").write_text("")
    with pytest.raises(FormatError, match="cannot be made: File exists"):
        demo(out=tmp_path / "file", frames=1)
