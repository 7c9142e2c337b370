"""The scripts in benchmarks/ run to their end, on little."""

from __future__ import annotations

import importlib
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PIL import Image

from motes.synthetic.clips import still
from motes.video.writer import VideoWriter

SCRIPTS = Path(__file__).parents[1] / "benchmarks"


def cells(table: str) -> list[list[str]]:
    """Return the lines of a table below its head."""
    lines = [line for line in table.splitlines() if line.startswith("|")]
    return [[cell.strip() for cell in line.strip("|").split("|")] for line in lines[2:]]


@pytest.mark.slow
def test_a_frame_from_file_to_file(tmp_path: Path) -> None:
    film = tmp_path / "film.mp4"
    clip = still((160, 120), (30, 50), 12)
    with VideoWriter(film, 25) as writer:
        for frame, _ in clip:
            writer.write(frame.pixels)
    box = ",".join(f"{value:.0f}" for value in clip[0][1][0].ellipse.box)
    small = ["--frames", "12", "--rounds", "1", "--size", "320x240", "--preset", "nummiaro"]
    line = [sys.executable, str(SCRIPTS / "end_to_end.py"), str(film), box, *small]
    done = subprocess.run(line, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    ((size, preset, *numbers),) = cells(done.stdout)
    assert (size, preset, len(numbers)) == ("320x240", "nummiaro", 8)


def test_the_parts_of_the_default_tracker_are_timed(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.syspath_prepend(SCRIPTS)
    script: Any = importlib.import_module("default_breakdown")
    assert all(callable(getattr(owner, name)) for owner, name in script.PARTS.values())


def test_an_angle_is_followed_on_a_turned_picture(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.syspath_prepend(SCRIPTS)
    script: Any = importlib.import_module("turned_pictures")
    monkeypatch.setattr(script, "PRESETS", ("maggio:O-ROH", "mean_shift"))
    pixels = np.zeros((120, 160, 3), np.uint8)
    pixels[30:90, 60:100:8] = pixels[30:60, 60:100] = 200  # stripes below a plain half
    (tmp_path / "Book" / "img").mkdir(parents=True)
    Image.fromarray(pixels).save(tmp_path / "Book" / "img" / "1.png")
    (tmp_path / "Book" / "groundtruth_rect.txt").write_text("61,31,40,60\n")
    assert script.main([str(tmp_path / "Book")]) == 0
    turns, upright = cells(capsys.readouterr().out)
    assert float(turns[1].split()[0]) < 10
    assert turns[2] == "1 of 1"
    assert float(upright[1].split()[0]) == pytest.approx(45, abs=1)  # it has no angle


def test_an_update_with_fewer_pixels(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.syspath_prepend(SCRIPTS)
    script: Any = importlib.import_module("fewer_pixels")
    for name, value in (("TARGETS", ((20, 30),)), ("FRAMES", 6), ("STARTING", 2)):
        monkeypatch.setattr(script, name, value)
    assert script.main() == 0
    ((film, target, *numbers),) = cells(capsys.readouterr().out)
    assert (film, target) == ("rendered", "20x30")
    assert len(numbers) == 5
    assert all(float(number.rstrip("%")) > 0 for number in numbers)
    folder = tmp_path / "Book" / "img"
    folder.mkdir(parents=True)
    for index in range(6):
        Image.new("RGB", (80, 60), (index, 90, 60)).save(folder / f"{index}.png")
    (tmp_path / "Book" / "groundtruth_rect.txt").write_text("11,11,20,30\n" * 6)
    assert script.main([str(tmp_path / "Book")]) == 0
    assert cells(capsys.readouterr().out)[0][:2] == ["Book", "20x30"]
