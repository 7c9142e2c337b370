"""motes demo: all files are there and hold what they should."""

from __future__ import annotations

import csv
import errno
import math
from contextlib import redirect_stderr, redirect_stdout
from io import StringIO
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from motes import synthetic
from motes.cli.demo import FILES, Score, demo, score
from motes.core.errors import ConfigError, FormatError
from motes.output.figures import Recorder
from motes.output.track_rows import COLUMNS
from motes.video.sources import open_source

FRAMES = 6


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
@pytest.mark.parametrize(("name", "width"), [("demo.mp4", 640), ("track.mp4", 1920)])
def test_the_videos_have_every_frame(folder: Path, name: str, width: int) -> None:
    with open_source(folder / name) as source:
        frames = list(source)
    assert len(frames) == FRAMES
    assert {(frame.width, frame.height) for frame in frames} == {(width, 480)}
    assert [frame.time for frame in frames] == pytest.approx([i / 25 for i in range(FRAMES)])


@pytest.mark.slow
def test_the_film_shows_the_clip(folder: Path) -> None:
    with open_source(folder / "demo.mp4") as source:
        for frame, (right, _) in zip(source, synthetic.demo(frames=FRAMES), strict=True):
            off = np.abs(frame.pixels.astype(int) - right.pixels)
            assert off.mean() < 6  # the grain that compression takes away


@pytest.mark.slow
@pytest.mark.parametrize("name", ["default.csv", "nummiaro.csv", "mean_shift.csv"])
def test_the_rows_are_complete_and_near_the_truth(folder: Path, name: str) -> None:
    found, truths = rows(folder / name), rows(folder / "truth.csv")
    assert tuple(found[0]) == COLUMNS
    assert [int(row["frame"]) for row in found] == list(range(FRAMES))
    assert {row["status"] for row in found} == {"tracking"}
    for row, truth in zip(found, truths, strict=True):
        numbers = [float(row[column]) for column in COLUMNS if column != "status"]
        assert all(math.isfinite(number) for number in numbers)
        assert (
            math.dist((float(row["x"]), float(row["y"])), (float(truth["x"]), float(truth["y"])))
            < 6
        )


@pytest.mark.slow
def test_the_truth_is_that_of_the_clip(folder: Path) -> None:
    for row, (frame, (truth,)) in zip(
        rows(folder / "truth.csv"), synthetic.demo(frames=FRAMES), strict=True
    ):
        numbers = [float(value) for value in row.values()]
        right = [frame.index, frame.time, *truth.ellipse, truth.visible]
        assert numbers == pytest.approx(right, abs=1e-5)


@pytest.mark.slow
def test_the_overlay_shows_all_estimates_and_particles_but_of_mean_shift(folder: Path) -> None:
    with open_source(folder / "demo.mp4") as film, open_source(folder / "track.mp4") as track:
        plain = list(film)[-1].pixels.astype(int)
        drawn = list(track)[-1].pixels.astype(int)
    around = slice(290, 400), slice(40, 160)  # the target, away from labels
    pink = []
    for panel in np.split(drawn, 3, axis=1):
        change = (panel - plain)[around]
        assert (change[..., 2] > 50).sum() > 150  # the outline, blue and white
        pink.append(int((change[..., 2] - change[..., 1] > 60).sum()))
        assert np.abs(change).max(axis=2).mean() < 80  # the rest is as it was
    assert min(pink[:2]) > 1.5 * pink[2]  # which has outlines in these colors alone


@pytest.mark.slow
def test_a_short_clip_still_has_a_strip(folder: Path) -> None:
    with Image.open(folder / "strip.png") as image:
        assert image.size == (300, 240)
    assert (folder / "strip.png").stat().st_size < 200_000


@pytest.mark.slow
def test_it_says_how_the_trackers_did_and_what_is_next(made: tuple[Path, str, str]) -> None:
    _, out, err = made
    for text in ("default", "nummiaro", "mean shift", "IoU", "never", " ms", "[red]"):
        assert text in out
    assert "motes track your_video.mp4 --init x,y,w,h --overlay out.mp4" in out
    assert err == ""  # no progress where there is no terminal


@pytest.mark.slow
def test_it_overwrites_only_on_demand(folder: Path) -> None:
    before = {path.name: path.read_bytes() for path in folder.iterdir()}
    with pytest.raises(FormatError, match="--overwrite"):
        demo(out=folder, frames=FRAMES)
    assert {path.name: path.read_bytes() for path in folder.iterdir()} == before


@pytest.mark.parametrize("name", FILES)
def test_one_file_there_is_enough_to_refuse_before_any_work(tmp_path: Path, name: str) -> None:
    (tmp_path / name).write_text("mine")
    with pytest.raises(FormatError, match=name):
        demo(out=tmp_path, frames=1)
    assert [path.name for path in tmp_path.iterdir()] == [name]
    assert (tmp_path / name).read_text() == "mine"


@pytest.mark.slow
def test_equal_seeds_give_equal_rows(folder: Path, tmp_path: Path) -> None:
    (tmp_path / "nummiaro.csv").write_text("old")
    demo(out=tmp_path, frames=FRAMES, overwrite=True)
    for name in ("default.csv", "nummiaro.csv", "mean_shift.csv", "truth.csv"):
        assert (tmp_path / name).read_bytes() == (folder / name).read_bytes()


def test_wrong_arguments_are_refused(tmp_path: Path) -> None:
    with pytest.raises(ConfigError, match="give 1 or more"):
        demo(out=tmp_path / "a", frames=0)
    with pytest.raises(ConfigError, match="give 0 or more"):
        demo(out=tmp_path / "a", seed=-1)
    assert not (tmp_path / "a").exists()
    (tmp_path / "file").write_text("")
    with pytest.raises(FormatError, match="cannot be made: File exists"):
        demo(out=tmp_path / "file", frames=1)


@pytest.mark.slow
def test_a_full_disk_is_reported(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def full(*_: object) -> None:
        raise OSError(errno.ENOSPC, "No space left on device")

    monkeypatch.setattr(Path, "write_text", full)
    monkeypatch.setattr(Recorder, "save", lambda *_: None)  # figures take long
    with pytest.raises(FormatError, match="No space left on device; make room"):
        demo(out=tmp_path / "demo", frames=1)


def test_the_score_of_a_run_worked_by_hand() -> None:
    #            hit  hit  miss hidden miss hit  miss, the last two visible
    overlaps = [1.0, 0.6, 0.05, 0.0, 0.0, 0.1, 0.02]
    visible = [1.0, 1.0, 0.5, 0.0, 0.1, 1.0, 1.0]
    tracking = [True, True, True, False, False, True, False]
    assert score(overlaps, visible, tracking) == pytest.approx(
        Score(overlap=1.77 / 6, half=2 / 6, lost=6, missed=4, admitted=3)
    )


def test_a_target_that_is_hit_last_or_hidden_at_the_end_is_not_lost() -> None:
    assert score([0.9, 0.0, 0.1], [1, 1, 1], [True] * 3).lost is None
    assert score([0.9, 0.0], [1, 0], [True] * 2).lost is None
    assert score([0.0, 0.0], [1, 1], [True] * 2).lost == 0
