"""`motes-lab bench`: what it measures and writes, and how it compares."""

import shutil
from pathlib import Path

import numpy as np
import pytest

from commands import read_csv
from evaluations import pictures
from motes import SourceError
from motes_lab.cli import main
from motes_lab.datasets.sot import load_dataset
from motes_lab.experiment import Experiment, Result
from motes_lab.report import markdown
from motes_lab.report.tables import Table
from motes_lab.speed import measure as speed, parts, report as speed_report
from motes_lab.speed.measure import MAIN
from motes_lab.speed.report import against, stored_ratios, trackers_table

SECONDS = {
    ("nummiaro", MAIN): [0.001, 0.002, 0.003],
    ("nummiaro", (28, 44)): [0.0005] * 3,
    ("maggio", MAIN): [0.008] * 3,
    ("cv2:mosse", MAIN): [0.004] * 3,
    ("cv2:csrt", MAIN): [0.03] * 3,
}
NAME = Path("earlier.md")


def texts(table: Table) -> list[dict[str, str]]:
    cells = ([cell.text for cell in row] for row in table.rows)
    return [dict(zip(table.head, row, strict=True)) for row in cells]


def test_medians_and_ratios() -> None:
    table = trackers_table(SECONDS, "One is missing.")
    assert "One is missing." in table.note
    rows = texts(table)
    assert [(row["tracker"], row["target"]) for row in rows][:2] == [
        ("nummiaro", "60x100"),
        ("nummiaro", "28x44"),
    ]
    assert [row["median ms"] for row in rows] == ["2.000", "0.500", "8.000", "4.000", "30.000"]
    assert rows[0]["95 % ms"] == "3.800"  # 0.8 of a step above the highest of three
    assert [row["times nummiaro"] for row in rows] == ["1.00", "0.250", "4.00", "2.00", "15.0"]
    assert [row["times cv2:mosse"] for row in rows[:3]] == ["0.500", "0.125", "2.00"]
    assert rows[0]["times cv2:csrt"] == "0.0667"


def test_stored_ratios_are_read_from_what_is_written() -> None:
    other = "| tracker | times cv2:csrt |\n|---|---|\n| none | – |"
    written = markdown.table(trackers_table(SECONDS, ""))
    stored = stored_ratios(f"# Speed\n\n{other}\n\nText | here.\n\n{written}\n\nMore.\n", NAME)
    assert stored == {
        ("nummiaro", "60x100", "cv2:mosse"): 0.5,
        ("nummiaro", "60x100", "cv2:csrt"): 0.0667,
        ("nummiaro", "28x44", "cv2:mosse"): 0.125,
        ("nummiaro", "28x44", "cv2:csrt"): 0.0167,
        ("maggio", "60x100", "cv2:mosse"): 2.0,
        ("maggio", "60x100", "cv2:csrt"): 0.267,
    }
    useless = (
        f"| tracker | target | times cv2:kcf |\n| default | 60x60 | {n} |" for n in ("inf", "0")
    )
    for text in ("", "no table", other, *useless):
        with pytest.raises(SourceError, match=r"earlier\.md holds no table of trackers"):
            stored_ratios(text, NAME)


def test_what_got_slower_is_marked() -> None:
    stored = {
        ("nummiaro", "60x100", "cv2:mosse"): 0.5 / 1.16,
        ("nummiaro", "60x100", "cv2:csrt"): 0.0667 / 1.14,
        ("nummiaro", "28x44", "cv2:mosse"): 0.125 * 3,
        ("maggio", "60x100", "cv2:csrt"): 0.267 / 2,
    }
    table = against(trackers_table(SECONDS, ""), stored)
    found = {tuple(row.values())[:3]: [*row.values()][3:] for row in texts(table)}
    assert found == {
        ("nummiaro", "60x100", "cv2:mosse"): ["0.500", "0.431", "+16%", "slower"],
        ("nummiaro", "60x100", "cv2:csrt"): ["0.0667", "0.0585", "+14%", ""],
        ("nummiaro", "28x44", "cv2:mosse"): ["0.125", "0.375", "-67%", ""],
        ("nummiaro", "28x44", "cv2:csrt"): ["0.0167", "–", "–", ""],
        ("maggio", "60x100", "cv2:mosse"): ["2.00", "–", "–", ""],
        ("maggio", "60x100", "cv2:csrt"): ["0.267", "0.134", "+100%", "slower"],
    }
    assert table.note.startswith("2 of 6 are more than 15% slower")


def test_real_sequences_have_ratios_and_their_geometric_means() -> None:
    milliseconds = {
        ("one", "default"): 4,
        ("one", "nummiaro"): 2,
        ("one", "cv2:nano=a.onnx,b.onnx"): 8,
        ("two", "default"): 2,
        ("two", "nummiaro"): 1,
        ("two", "cv2:nano=a.onnx,b.onnx"): 16,
    }
    seconds = {key: [0.001 * value] * 3 for key, value in milliseconds.items()}
    table = speed_report.sequences_table(seconds, "One is missing.")
    assert table.note.endswith("One is missing.")
    *_, last = rows = texts(table)
    assert [row["tracker"] for row in rows] == ["default", "nummiaro", "cv2:nano"] * 2
    assert last == {
        "sequence": "two",
        "tracker": "cv2:nano",
        "median ms": "16.000",
        "95 % ms": "16.000",
        "times default": "8.00",
        "times nummiaro": "16.0",
    }
    feet = [[cell.text for cell in row] for row in table.foot]
    assert feet[1] == ["all", "nummiaro", "", "", "0.500", "1.00"]
    assert feet[2] == ["all", "cv2:nano", "", "", "4.00", "8.00"]


@pytest.fixture
def sequences(tmp_path: Path) -> Path:
    """Return a folder with a real sequence, the first frame without its target."""
    folder = tmp_path / "data" / "sot" / "David"
    pictures(folder / "img", 5, (160, 120))
    (folder / "groundtruth_rect.txt").write_text("nan,nan,nan,nan\n" + "41,31,40,50\n" * 4)
    return folder.parents[1]


def test_trackers_on_a_real_sequence_take_turns_on_bgr_frames(
    sequences: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    seen: list[tuple[str, int, tuple[int, ...]]] = []

    class Recorder:
        def __init__(self, name: str) -> None:
            self.name = name

        def init(self, image: np.ndarray, box: list[int]) -> None:
            seen.append((self.name, int(image[0, 0, 0]), tuple(box)))

        def update(self, image: np.ndarray) -> None:
            assert image.flags.c_contiguous
            seen.append((self.name, int(image[0, 0, 0]), image.shape))

    monkeypatch.setattr(speed, "OpenCVTracker", Recorder)
    monkeypatch.setattr(speed, "peer", Recorder)
    [sequence] = load_dataset(sequences / "sot")[0]
    found, problems = speed.in_lockstep(["nummiaro", "cv2:kcf"], sequence, 3)
    assert not problems
    names, values, third = zip(*seen, strict=True)
    assert names == ("nummiaro", "cv2:kcf") * 3
    assert values == (240, 240, 230, 230, 220, 220)
    assert third == (*[(40, 30, 40, 50)] * 2, *[(120, 160, 3)] * 4)
    assert {name: len(times) for name, times in found.items()} == {"nummiaro": 2, "cv2:kcf": 2}
    longer, _ = speed.in_lockstep(["nummiaro"], sequence, 99)
    assert len(longer["nummiaro"]) == 3


def test_a_tracker_of_opencv_that_fails_is_left_out(
    sequences: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    class Failing:
        def init(self, image: np.ndarray, box: list[int]) -> None:
            self.left = 2

        def update(self, image: np.ndarray) -> None:
            self.left -= 1
            if not self.left:
                raise ValueError("outside\nthe frame")

    monkeypatch.setattr(speed, "peer", lambda _: Failing())
    [sequence] = load_dataset(sequences / "sot")[0]
    found, (problem,) = speed.in_lockstep(["cv2:kcf", "nummiaro"], sequence, 4)
    assert {name: len(times) for name, times in found.items()} == {"cv2:kcf": 1, "nummiaro": 3}
    assert (problem.where, problem.what) == ("cv2:kcf on David", "ValueError: outside the frame")
    real = {("David", name): times for name, times in found.items()}
    real["David", "default"] = real["David", "nummiaro"]
    assert "cv2:kcf" not in {cell.text for row in speed_report.sequences_table(real, "").rows
                             for cell in row}  # fmt: skip


@pytest.fixture
def small(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> Path:
    """Let the command measure little, in an empty folder."""
    for module, name, value in (
        (parts, "FRAMES", 3),
        (parts, "SIZE", (200, 160)),
        (speed, "TARGETS", (MAIN,)),
        (speed, "OURS", ("nummiaro",)),
        (speed, "PEERS", ("cv2:mosse",)),
    ):
        monkeypatch.setattr(module, name, value)
    monkeypatch.chdir(tmp_path)
    monkeypatch.delenv("MOTES_DATA", raising=False)
    return tmp_path


@pytest.mark.slow
def test_the_command_writes_all_there_is(
    small: Path, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    line = ["bench", "--rounds", "1", "--out", "new"]
    assert main(line) == 0
    out, error = capfd.readouterr()
    assert error.endswith(f"wrote {Path('new') / 'bench'}.md, with CSV.\n")
    assert "slower" not in out
    written = {path.name for path in Path("new").iterdir()}
    assert written == {"bench-trackers.csv", "bench.md"}

    measured: list[object] = []

    def steps(*given: object) -> Experiment:
        measured.append(given)
        yield Result({})

    monkeypatch.setattr("motes_lab.cli.bench.measured", steps)
    assert main(line) == 5  # before anything is measured
    assert main([*line, "--against", "none.md"]) == 3
    Path("text.md").write_text("text")
    assert main([*line, "--against", "text.md"]) == 3
    assert not measured
    assert "text.md holds no table" in capfd.readouterr().err
    assert {path.name for path in Path("new").iterdir()} == written


def test_real_sequences_are_measured_too(
    small: Path, sequences: Path, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(speed, "FOLLOWERS", ("nummiaro",))
    monkeypatch.setattr(speed_report, "FOLLOWERS", ("nummiaro",))
    monkeypatch.setattr(speed, "RIVALS", ("cv2:mosse",))
    line = ["bench", "--rounds", "1", "--out", "new"]
    monkeypatch.setenv("MOTES_DATA", str(sequences))
    assert main([*line, "--part", "sequences"]) == 0
    rows = read_csv("new/bench-sequences.csv")
    assert [(row["sequence"], row["tracker"]) for row in rows] == [
        (name, tracker) for name in ("David", "all") for tracker in ("nummiaro", "cv2:mosse")
    ]
    capfd.readouterr()

    monkeypatch.delenv("MOTES_DATA")
    (sequences / "sot").rename("mine")
    shutil.copytree("mine", "david")
    Path("mine/David").rename("mine/Other")
    for more, code, message in (
        (["--data", "new"], 3, "There is no sequence in new"),
        (["--data", "mine"], 3, "--data mine has none of the sequences David, Jogging-1"),
        (["--nano", "a,b"], 2, "--nano needs real sequences; give their folder with --data."),
        (["--data", "david", "--nano", "a,b"], 2, "cv2:nano needs 2 ONNX files"),
    ):
        assert main([*line[:-1], "other", *more]) == code
        assert message in capfd.readouterr().err
    assert not Path("other").exists()
