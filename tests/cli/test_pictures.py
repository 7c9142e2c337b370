"""Slit scans, heatmaps and paths of motes watch."""

from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from motes import Frame, Status
from motes.cli import Moment, main
from motes.cli.pictures import Paths
from motes.output.scene_overlay import heatmap
from motes.output.slit_scan import COLORS, COLUMNS, MARGIN, SCALE, SIDE, SlitScan
from red_box import walk
from sightings import seen


def frame(index: int, height: int = 40) -> np.ndarray[tuple[int, int, int], np.dtype[np.uint8]]:
    """Return a gray picture with a red column that moves one pixel a frame."""
    pixels = np.full((height, 60, 3), 90, np.uint8)
    pixels[:, index % 60] = (250, 0, 0)
    return pixels


def test_a_slit_scan_has_time_downwards_and_the_line_across() -> None:
    scan = SlitScan((5, 20, 54, 20))
    for index in range(50):
        scan.add(Frame(index, index / 25, frame(index)))
    picture = scan.picture()
    assert picture.shape == (SCALE * 50, MARGIN + SCALE * 50, 3)
    for index in range(6, 50):  # the column is under the line's pixel index - 5
        row = picture[SCALE * index, MARGIN:]
        assert np.flatnonzero(row[:, 1] == 0).tolist() == [
            SCALE * (index - 5),
            SCALE * (index - 5) + 1,
        ]
    scan.mark(30, (25, 20), 7, second=False)
    marked = scan.picture()
    assert (marked[SCALE * 30, MARGIN:] != picture[SCALE * 30, MARGIN:]).any(axis=1).mean() > 0.9
    assert (marked[: SCALE * 20] == picture[: SCALE * 20]).all()
    named = SlitScan((5, 20, 54, 20), ("in", "out"))
    named.add(Frame(0, 0.0, frame(0)))
    below = named.picture()[SCALE:]
    for color in COLORS:  # a stroke in the color of the marks before each name
        assert (below == color).all(axis=2).sum() > 40


@pytest.mark.parametrize("end", [5, 30, 54])
def test_the_number_of_a_mark_lies_beside_it(end: int) -> None:
    pictures = []
    for identity in (1, 888):
        scan = SlitScan((5, 20, 54, 20))
        for index in range(50):
            scan.add(Frame(index, index / 25, np.full((40, 60, 3), 90, np.uint8)))
        scan.mark(20, (end, 20), identity, second=False)
        pictures.append(scan.picture().astype(int))
    rows, columns = np.abs(pictures[0] - pictures[1]).any(axis=2).nonzero()
    assert len(columns) > 20
    assert np.abs(columns - MARGIN - SCALE * (end - 5)).min() > 5
    dark = pictures[1][rows.min() : rows.max() + 1, columns.min() : columns.max() + 1]
    assert (dark < 50).all(axis=2).sum() > 20  # it has an edge


def test_beside_each_mark_is_what_was_counted() -> None:
    """As it was when it came to the other side; two at about the same time are side by side."""
    scan, looks = SlitScan((5, 20, 54, 20)), {1: (250, 0, 0), 2: (0, 0, 250)}
    for index in range(100):
        pixels, feet = np.full((40, 60, 3), 90, np.uint8), {1: index - 20, 2: index - 30}
        for identity, y in feet.items():  # it turns green later
            color = looks[identity] if y < 24 else (0, 250, 0)
            pixels[max(0, y - 10) : max(0, y + 1), 30 * identity - 15 : 30 * identity - 4] = color
        scan.add(
            Frame(index, index / 25, pixels),
            [seen(index, (30 * n - 10, y), identity=n) for n, y in feet.items() if y > 9],
        )
    alone = scan.picture().shape[1]
    for identity, y in feet.items():
        scan.mark(99 - y + 21, (30, 20), identity, second=identity == 2)
    scan.mark(3, (30, 20), 9, second=False)  # of an object that was never seen
    picture = scan.picture()
    assert picture.shape[1] == alone + 2 * SIDE
    for n, color in enumerate(looks.values()):
        look = picture[:, alone + n * SIDE :][:, 4 : SIDE - 4]
        assert (look == color).all(axis=2).sum() > 200
        assert not (look == (0, 250, 0)).all(axis=2).any()
    for n in range(20):  # no picture is wider than a screen
        scan.mark(40, (30 + n, 20), 1, second=False)
    assert scan.picture().shape == (SCALE * 100, alone + COLUMNS * SIDE, 3)


def test_a_heatmap_is_red_where_feet_have_been() -> None:
    gray = np.full((100, 160, 3), 90, np.uint8)
    seconds = np.zeros((100, 160))
    seconds[50, 40] = 3
    warm = heatmap(gray, seconds).astype(int)
    assert warm[50, 40, 0] - warm[50, 40, 2] > 100
    assert (warm[50, 120] == 90).all()
    assert (heatmap(gray, np.zeros((100, 160))) == gray).all()


def test_a_path_is_interrupted_where_its_object_is_not_seen(tmp_path: Path) -> None:
    out, gray = tmp_path / "paths.png", np.full((60, 160, 3), 90, np.uint8)
    with Paths(out, overwrite=False) as picture:
        for index, x in enumerate(range(10, 150, 5)):
            status = Status.OCCLUDED if 10 <= index < 14 else Status.TRACKING
            there = [] if index >= 14 and index < 18 else [seen(index, (x, 40), status)]
            picture.write(Moment(Frame(index, index / 4, gray), there))
    drawn = np.ptp(np.array(Image.open(out)).astype(int), axis=2)[40] > 50
    assert drawn[10:56].all()
    assert not drawn[56:100].any()
    assert drawn[100:145].all()


@pytest.mark.slow
def test_the_pictures_of_a_run(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    film = tmp_path / "film.mkv"
    walk(film, 50, enters=4)
    out = [str(tmp_path / name) for name in ("s.png", "h.png", "p.png")]
    pictures = ["--slit", out[0], "--heatmap", out[1], "--paths", out[2]]
    lines = ["--line", "80,0,80,95", "--line", "0,20,159,20"]
    assert main(["watch", str(film), *lines, *pictures]) == 0
    assert "s-line-1.png" in capsys.readouterr().err
    for name, shape in (
        ("s-line-1", (134, 252 + SIDE)),
        ("s-line-2", (134, 380)),
        ("h", (96, 160)),
    ):
        assert np.array(Image.open(tmp_path / f"{name}.png")).shape[:2] == shape
    blue = np.array(Image.open(tmp_path / "s-line-1.png")).astype(int)
    assert (
        (blue[:, MARGIN:252] == (230, 159, 0)).all(axis=2).mean(axis=1) > 0.8
    ).sum() == 1  # a mark
    assert main(["watch", str(film), "--slit", str(tmp_path / "x.png")]) != 0
    assert "give one with --line" in capsys.readouterr().err
    assert main(["watch", str(film), "--paths", str(tmp_path / "x.jpg")]) != 0
    assert "does not end in .png" in capsys.readouterr().err
