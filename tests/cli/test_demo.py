"""motes demo: all files are there and hold what they should."""

from __future__ import annotations

import csv
import html
import json
import math
import re
import sys
from contextlib import redirect_stderr, redirect_stdout
from io import StringIO
from itertools import islice
from pathlib import Path
from types import ModuleType

import numpy as np
import pytest

from motes import synthetic
from motes.cli import demo as module
from motes.cli.demo import FILES, PAGE, STORIES, Score, TrackerRun, demo, score
from motes.core.errors import ConfigError, FormatError
from motes.core.frame import Frame
from motes.core.geometry import Box, Ellipse
from motes.core.track import COLUMNS
from motes.rows.schema import NUMBERS
from motes.synthetic.clips import Truth
from motes.video.sources import open_source
from motes.video.writer import VideoWriter

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


def rows(path: Path) -> list[dict[str, str]]:
    with path.open(newline="") as file:
        return list(csv.DictReader(file))


@pytest.mark.slow
def test_it_writes_all_files_and_no_others(folder: Path) -> None:
    assert sorted(path.name for path in folder.iterdir()) == sorted(FILES)


@pytest.mark.slow
@pytest.mark.parametrize("name", [n for n in FILES if n.endswith(".mp4")])
def test_the_videos_have_every_frame(folder: Path, name: str) -> None:
    with open_source(folder / name) as source:
        frames = list(source)
    assert len(frames) == FRAMES
    sizes = {(480, 360)} if name.startswith("beetle") else {(480, 270)}
    assert {(frame.width, frame.height) for frame in frames} == sizes
    assert [frame.time for frame in frames] == pytest.approx([i / 25 for i in range(FRAMES)])


@pytest.mark.slow
def test_the_films_do_not_depend_on_the_number_of_cores(
    folder: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("MOTES_THREADS", "1")
    with VideoWriter(tmp_path / "street.mp4", 25) as writer:
        for frame, _ in islice(STORIES[1].film(0), FRAMES):
            writer.write(frame.pixels)
    assert (tmp_path / "street.mp4").read_bytes() == (folder / "street.mp4").read_bytes()


@pytest.mark.slow
@pytest.mark.parametrize("story", STORIES, ids=NAMES)
def test_the_films_and_truths_are_those_of_the_scenes(folder: Path, story: module.Story) -> None:
    truths = rows(folder / f"{story.name}-truth.csv")
    assert len(truths) == FRAMES
    with open_source(folder / f"{story.name}.mp4") as source:
        for frame, row, (right, (truth, *_)) in zip(source, truths, story.film(0), strict=False):
            off = np.abs(frame.pixels.astype(int) - right.pixels)
            assert off.mean() < 6  # the grain that compression takes away
            numbers = [float(value) for value in row.values()]
            assert numbers == pytest.approx(
                [right.index, right.time, *truth.ellipse, truth.visible], abs=1e-5
            )


@pytest.mark.slow
@pytest.mark.parametrize("name", NAMES)
def test_the_rows_are_complete_and_near_the_truth(folder: Path, name: str) -> None:
    found, truths = rows(folder / f"{name}.csv"), rows(folder / f"{name}-truth.csv")
    assert tuple(found[0]) == COLUMNS
    assert [int(row["frame"]) for row in found] == list(range(FRAMES))
    assert {row["status"] for row in found} == {"tracking"}
    for row, truth in zip(found, truths, strict=True):
        numbers = [float(row[column]) for column in NUMBERS if column in COLUMNS[:-1]]
        assert all(math.isfinite(number) for number in numbers)
        places = [(float(each["x"]), float(each["y"])) for each in (row, truth)]
        assert math.dist(*places) < 6


@pytest.mark.slow
@pytest.mark.parametrize("name", NAMES)
def test_the_overlay_shows_the_estimate_and_its_particles(folder: Path, name: str) -> None:
    with (
        open_source(folder / f"{name}.mp4") as film,
        open_source(folder / f"{name}-tracked.mp4") as tracked,
    ):
        plain, drawn = (list(source)[-1].pixels.astype(int) for source in (film, tracked))
    x, y = (round(float(rows(folder / f"{name}.csv")[-1][key])) for key in ("x", "y"))
    around = slice(max(y - 60, 0), y + 60), slice(max(x - 60, 0), x + 60)
    change = (drawn - plain)[around]
    assert (change[..., 2] > 50).sum() > 100  # the outline is blue
    assert (change[..., 2] - change[..., 1] > 60).sum() > 10  # and the particles are pink


@pytest.mark.slow
def test_the_page_shows_all_films_and_every_frame_of_the_status(folder: Path) -> None:
    page = (folder / PAGE).read_text()
    assert re.findall('src="([^"]+)"', page) == [
        "beetle-tracked.mp4", "street-tracked.mp4", "street-counted.mp4", "player-tracked.mp4",
    ]  # fmt: skip
    shown = [json.loads(html.unescape(text)) for text in re.findall('data-states="([^"]+)"', page)]
    for story, states in zip(STORIES, shown, strict=True):
        assert story.title in page
        found = rows(folder / f"{story.name}.csv")
        assert [state for state, _ in states] == [row["status"] for row in found]
        confidences = [float(row["confidence"]) for row in found]
        assert [confidence for _, confidence in states] == pytest.approx(confidences, abs=0.006)
    assert "motes watch counted 0 of 0 cars" in page
    assert "$" not in page.replace("${", "")


@pytest.mark.slow
def test_it_says_how_the_trackers_did_and_what_is_next(made: tuple[Path, str, str]) -> None:
    _, out, err = made
    for text in (*NAMES, "IoU > 0.5", "and says so", "0 of 0", " ms", "[red]", "index.html"):
        assert text in out
    assert "motes track your_video.mp4 --init x,y,w,h --overlay out.mp4" in out
    assert sorted(err.splitlines()) == sorted(f"{story.title}." for story in STORIES)


@pytest.mark.slow
def test_it_overwrites_only_on_demand(folder: Path) -> None:
    before = {path.name: path.read_bytes() for path in folder.iterdir()}
    with pytest.raises(FormatError, match="--overwrite"):
        demo(out=folder, frames=FRAMES)
    assert {path.name: path.read_bytes() for path in folder.iterdir()} == before


def test_any_file_there_is_enough_to_refuse_before_any_work(tmp_path: Path) -> None:
    for name in FILES:
        path = tmp_path / name
        path.write_text("mine")
        with pytest.raises(FormatError, match=re.escape(name)):
            demo(out=tmp_path, frames=1)
        assert list(tmp_path.iterdir()) == [path]
        assert path.read_text() == "mine"
        path.unlink()


@pytest.mark.slow
def test_old_files_are_replaced_on_demand(tmp_path: Path) -> None:
    (tmp_path / "beetle.csv").write_text("old")
    assert demo(out=tmp_path, frames=1, overwrite=True) == 0
    assert len(rows(tmp_path / "beetle.csv")) == 1


def test_wrong_arguments_are_refused(tmp_path: Path) -> None:
    with pytest.raises(ConfigError, match="give 1 or more"):
        demo(out=tmp_path / "a", frames=0)
    with pytest.raises(ConfigError, match="give 0 or more"):
        demo(out=tmp_path / "a", seed=-1)
    assert not (tmp_path / "a").exists()
    (tmp_path / "file").write_text("")
    with pytest.raises(FormatError, match="cannot be made: File exists"):
        demo(out=tmp_path / "file", frames=1)


def test_mean_shift_stands_in_for_an_opencv_without_csrt(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "cv2", ModuleType("cv2"))
    assert [run.name for run in module._rivals(("CSRT", "KCF"))] == ["mean shift"]


@pytest.mark.parametrize(("patience", "stops"), [(3, True), (math.inf, False)])
def test_a_tracker_that_stays_off_the_target_is_stopped(patience: float, stops: bool) -> None:
    target, away = Box(0, 0, 10, 10), Box(50, 50, 10, 10)
    boxes = iter([away, away, target, away, away, away, target])
    run = TrackerRun("", lambda *_: None, lambda _: (True, next(boxes)), patience)
    frame = Frame(0, 0.0, np.zeros((8, 8, 3), np.uint8))
    for _ in range(8):
        run.step(frame, Truth(Ellipse.from_box(target), 1.0))
    assert run.overlaps == pytest.approx([1, 0, 0, 1, 0, 0, 0, 0 if stops else 1])
    assert len(run.tracking) == 8
    assert len(run.box) == (0 if stops else 4)


def test_crossings_are_counted_from_the_truth() -> None:
    street = synthetic.Street()
    assert module._crossings(150, street.truths(0), street.truths(len(street) - 1)) == 7


def test_the_score_of_a_run_worked_by_hand() -> None:
    #            hit  hit  miss hidden miss hit  miss
    overlaps = [1.0, 0.6, 0.05, 0.0, 0.0, 0.1, 0.02]
    visible = [1.0, 1.0, 0.5, 0.0, 0.1, 1.0, 1.0]
    tracking = [True, True, True, False, False, True, False]
    assert score(overlaps, visible, tracking) == pytest.approx(
        Score(half=2 / 5, missed=4, admitted=3)
    )
