"""`motes-lab evaluate` with many objects."""

import shutil
from collections.abc import Iterator
from pathlib import Path

import pytest

import arena
from arena import Go, at_home, evaluating, table
from crowds import TRACKERS, write_crowd
from in_process import work_here
from motes_lab.cli import main
from motes_lab.mot_scores import COLUMNS


@pytest.fixture(scope="module")
def home(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Path]:
    """Return the current folder for all tests: two sequences, a bad one, some trackers."""
    folder = tmp_path_factory.mktemp("home")
    for name, shift in (("a", 0), ("b", 4)):
        write_crowd(folder / "data" / name, shift)
        (folder / "mine").mkdir(exist_ok=True)
        shutil.copy(folder / "data" / name / "gt" / "gt.txt", folder / "mine" / f"{name}.txt")
    shutil.copytree(folder / "data", folder / "worse")
    (folder / "worse" / "b" / "gt" / "gt.txt").write_text("1,1,5,6,20,30,1\n1,1,5,6,20,30,1\n")
    arena.write_sequence(folder / "one" / "a", arena.still())
    (folder / "crowds_of.py").write_text(TRACKERS)
    with at_home(folder, "crowds_of"), pytest.MonkeyPatch.context() as patch:
        work_here(patch)
        yield folder


@pytest.fixture
def go(home: Path, capfd: pytest.CaptureFixture[str]) -> Go:
    return evaluating(capfd)


WHOLE = "--tracker results=mine --tracker crowds_of:Seeded --seeds 2 --workers 1"


@pytest.fixture(scope="module")
def whole(home: Path) -> str:
    """Return the folder of a run that nothing disturbed."""
    assert main(["evaluate", "data", *WHOLE.split(), "--out", "whole"]) == 0
    return "whole"


@pytest.mark.slow
def test_results(whole: str) -> None:
    lines = table(whole)
    assert tuple(lines[0]) == COLUMNS
    names = [(line["tracker"], line["sequence"], line["seed"]) for line in lines]
    assert names == [
        ("results=mine", "a", "0"), ("results=mine", "b", "0"),
        *(("crowds_of:Seeded", name, seed) for name in "ab" for seed in "01"),
        ("results=mine", "COMBINED", "0"),
        ("crowds_of:Seeded", "COMBINED", "0"), ("crowds_of:Seeded", "COMBINED", "1"),
    ]  # fmt: skip
    assert {line["mota"] for line in lines} == {"1"}
    motp = {line["sequence"]: float(line["motp"]) for line in lines if line["seed"] == "1"}
    assert motp == pytest.approx({"a": 19 / 21, "b": 15 / 25, "COMBINED": (19 / 21 + 15 / 25) / 2})
    tracks = Path(whole, "tracks", "results%3Dmine", "a")
    assert sorted(path.name for path in tracks.iterdir()) == ["mot-0.csv", "mot-0.txt"]
    assert (tracks / "mot-0.txt").read_text().splitlines()[0] == "1,1,62,30,20,40,1,-1,-1,-1"
    assert "crowds_of:Seeded" in Path(whole, "summary.md").read_text()


@pytest.mark.slow
def test_other_detections_or_another_detector_are_not_resumed(whole: str, go: Go) -> None:
    code, out, error = go(f"data {WHOLE} --out whole --resume --detector crowds_of:Nothing")
    assert (code, out) == (5, "")
    assert "whole cannot be resumed with this tracker crowds_of:Seeded" in error
    text = (path := Path("data/b/det/det.txt")).read_text()
    path.write_text(text.replace("0.9", "0.8", 1))
    code, out, error = go(f"data {WHOLE} --out whole --resume")
    path.write_text(text)
    assert (code, out) == (5, "")
    assert "with this sequence b, which had other truth or detections" in error


@pytest.mark.parametrize(
    ("line", "code", "error"),
    [
        ("data", 2, "There is no tracker; name some, such as --tracker trackers:sort"),
        ("data --tracker nummiaro", 2, "no tracker to run. tracker nummiaro: There is no tracker"),
        ("data --tracker crowds_of:Echo --protocol ope", 2, "--protocol is for datasets with one"),
        ("data --tracker crowds_of:Echo --annotation x", 2, "--annotation is for datasets"),
        ("data --tracker crowds_of:Echo --first-pixel 0", 2, "--first-pixel is for datasets with"),
        ("one --detector background", 2, "--detector is for datasets with many objects, but"),
        ("data --tracker crowds_of:Echo --detector no:x", 2, "The detector no:x: There is neither"),
        ("data --tracker crowds_of:Echo --sequence c", 2, "--sequence c fits none of a, b"),
        ("worse --sequence b --tracker crowds_of:Echo", 3, "No sequence of worse can be used."),
    ],
)
def test_refusals(line: str, code: int, error: str, go: Go) -> None:
    found, out, message = go(f"{line} --out refused")
    assert (found, out) == (code, "")
    assert error in message
    assert message.count("\n") == 1
    assert not Path("refused").exists()
