"""`motes track` with several films: a folder of rows, one summary, and films that fail."""

from __future__ import annotations

import csv
from collections.abc import Callable
from pathlib import Path

import pytest
from PIL import Image

from motes.cli import main
from motes.synthetic.clips import crowd

Go = Callable[[str], tuple[int, list[str]]]
FRAMES = 8
BOTH = "a,0,40,30,20,30\nb,0,40,30,20,30\n"


@pytest.fixture
def go(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]) -> Go:
    """Run motes in a folder with the films a and b, which are folders of images."""
    monkeypatch.chdir(tmp_path)
    for name in ("a", "b"):
        Path(name).mkdir()
        for frame, _ in crowd((120, 90), (20, 30), FRAMES):
            Image.fromarray(frame.pixels).save(f"{name}/{frame.index}.png")

    def run(line: str) -> tuple[int, list[str]]:
        code = main(line.split())
        return code, capfd.readouterr()[1].splitlines()

    return run


def keys(text: str) -> None:
    Path("all.csv").write_text("film,frame,x,y,width,height\n" + text)


def rows(name: str) -> list[dict[str, str]]:
    return list(csv.DictReader(Path(name).read_text().splitlines()))


def test_each_film_has_its_rows(go: Go) -> None:
    keys("a,0,40,30,20,30\nb,2,40,30,20,30\nb,5,absent\nb,6,50,30,20,30\n")
    code, said = go("track a b --keyframes all.csv --preset mean_shift -o out")
    assert code == 0
    assert "motes: a: the images have no frame rate" in said[0]
    assert said[1].startswith("motes: a: 8 frames, 1 keyframe, tracking in 8")
    assert said[-1] == "motes: 2 films, 2 done, 0 failed, 16 frames; wrote 2 files in out."
    names = ["a.csv", "a.csv.run.json", "b.csv", "b.csv.run.json"]
    assert sorted(path.name for path in Path("out").iterdir()) == names
    assert go("track a --keyframes all.csv --preset mean_shift -o one.csv")[0] == 0
    assert Path("out/a.csv").read_text() == Path("one.csv").read_text()
    found = rows("out/b.csv")
    statuses = [row["status"] for row in found]
    assert statuses[:4] + statuses[5:] == ["tracking"] * 4 + ["absent"] + ["tracking"] * 2
    assert (found[6]["x"], found[6]["a"]) == ("59.500", "10.000")  # as it was marked


def test_each_film_has_its_masks_figures_and_metres(go: Go) -> None:
    keys("a,0,40,30,20,30\nb,0,40,30,20,30\n")
    line = "track a b --keyframes all.csv --preset mean_shift -o out --scale 20"
    assert go(f"{line} --masks masks --figures path")[0] == 0
    assert [len(list(Path("masks", name).iterdir())) for name in "ab"] == [FRAMES, FRAMES]
    assert Path("out/b.path.pdf").exists()
    assert float(rows("out/b.csv")[0]["x_m"]) == pytest.approx(49.5 / 20, abs=1e-5)
    before = Path("out/b.csv").read_bytes()
    Path("out/b.csv").unlink()
    assert go(f"{line} --resume")[0] == 0
    assert Path("out/b.csv").read_bytes() == before


def test_a_film_that_fails_does_not_end_the_others(go: Go) -> None:
    Path("broken.mp4").write_text("no film")
    keys("broken.mp4,0,1,1,9,9\na,0,40,30,20,30\n")
    code, said = go(
        "track broken.mp4 a --keyframes all.csv --preset mean_shift -o out --format mot"
    )
    assert code == 6
    assert "broken.mp4 failed: " in said[0]
    assert said[-1] == "motes: 2 films, 1 done, 1 failed, 8 frames; wrote 1 file in out."
    assert len(Path("out/a.txt").read_text().splitlines()) == FRAMES


@pytest.mark.parametrize(
    ("line", "text", "message"),
    [
        ("a b -o out", "a,0,40,30,20,30\n", "no keyframe of b; add a row b,0,x,y,w,h"),
        ("a b -o out", "0,40,30,20,30\n", "a row names no film; begin each row"),
        ("a b -o out", f"{BOTH}c,0,1,1,9,9\n", "c is not one of the films"),
        ("a a -o out", "a,0,40,30,20,30\n", "a is given twice"),
        ("a b -o out", f"{BOTH}a,99,40,30,20,30\n", "keyframe 99 is outside of a, .* frames 0"),
        ("a b -o out", "a,0,400,30,20,30\nb,0,40,30,20,30\n", "Keyframe 0 of a: .* outside"),
        ("a b -o out", f"{BOTH}a,0,41,30,20,30\n", "frame 0 contradict each other"),
        ("a b", BOTH, "Several films need a folder for their rows"),
        ("a b -o out --overlay o.mp4 --show", BOTH, "--overlay and --show are for one film"),
        ("a b -o out --masks m.json", BOTH, "--masks m.json: several films need a folder"),
        ("a b -o out --init 1,2,9,9", BOTH, "targets of several films are in the file"),
        ("a b -o out --at 3=1,2,9,9", BOTH, "targets of several films are in the file"),
        ("a ./b/../a -o out", "a,0,40,30,20,30\n", "a fits a and ./b/../a; name one"),
    ],
)
def test_wrong_input_is_one_line_before_anything_is_computed(
    go: Go, line: str, text: str, message: str
) -> None:
    import re

    keys(text)
    code, said = go(f"track {line} --keyframes all.csv")
    assert (code in (2, 3, 5), len(said)) == (True, 1), said
    assert re.search(message, said[0]), said
    assert not Path("out/a.csv").exists()


def test_patterns_of_films(go: Go) -> None:
    from motes.cli.track_films import films_of

    for name in ("x1.mp4", "x2.mp4"):
        Path(name).touch()
    assert films_of(["x*.mp4", "a/*.png"]) == ["x1.mp4", "x2.mp4", "a/*.png"]
