"""Objects detected over objects present, on made-up crowds and from the command line."""

from collections.abc import Iterator
from itertools import permutations
from pathlib import Path

import numpy as np
import pytest

from commands import read_csv
from crowds import rows, write_crowd
from motes import Detection, Detector, Frame, Scene, scene_config
from motes.core import iou
from motes_lab.cli import main
from motes_lab.datasets.mot import MotSequence, load_mot_dataset
from motes_lab.datasets.mot_rows import MotRows
from motes_lab.experiment import Result
from motes_lab.papers import zhao_pei_figure9


def crowd(folder: Path, shift: float = 0.0) -> MotSequence:
    (found,), problems = load_mot_dataset(write_crowd(folder, shift))
    assert not problems
    return found


def counted(
    each: MotSequence, detector: Detector | None = None
) -> tuple[Result, list[list[float]]]:
    """Return the last result, and there, followed and detected of every frame."""
    finder = detector or zhao_pei_figure9.default_detector(each)
    steps = zhao_pei_figure9.figure9(each, Scene(finder), "it")
    *_, result = steps
    assert result.share == 1
    table, all_frames = result.tables.values()
    (row,) = all_frames.rows
    assert [cell.text for cell in row[:3]] == [each.name, "it", str(each.frames)]
    assert row[3:] == table.foot[0][1:]
    assert table.head[1:4] == ("present", "followed", "detected accurately")
    return result, [[cell.value or 0.0 for cell in row[1:4]] for row in table.rows]


def test_objects_are_followed_from_their_third_frame_on(tmp_path: Path) -> None:
    result, counts = counted(crowd(tmp_path))
    assert counts == [[2, 0, 0]] * 2 + [[2, 2, 2]] * 10
    table = result.tables[""]
    assert [row[0].value for row in table.rows] == list(range(12))
    assert [row[4].text for row in table.rows] == ["0.000"] * 2 + ["1.000"] * 10
    assert [cell.text for cell in table.foot[0]] == ["all", "24", "20", "20", "0.833"]


def test_another_detector_sees_each_frame_at_its_time(tmp_path: Path) -> None:
    seen: list[Frame] = []

    class Nobody:
        warnings = {"light": "It is dark."}  # noqa: RUF012

        def __call__(self, frame: Frame) -> list[Detection]:
            seen.append(frame)
            return []

    each = crowd(tmp_path)
    result, counts = counted(
        MotSequence(each.name, each.source, 5, 4.0, each.truth, None), Nobody()
    )
    assert counts == [[2, 0, 0]] * 5
    assert [frame.time for frame in seen] == [0, 0.25, 0.5, 0.75, 1]
    assert result.tables[""].note.endswith(" It is dark.")


def test_the_hidden_are_followed_and_the_lost_are_not(tmp_path: Path) -> None:
    """Detections end; 3 seconds later, in frame 18, a scene gives up."""
    (each,), _ = load_mot_dataset(write_crowd(tmp_path, frames=20))
    assert each.detections is not None
    early = each.detections.where(each.detections.frames <= 6)
    _, counts = counted(MotSequence(each.name, each.source, 20, 4, each.truth, early))
    assert counts == [[2, 0, 0]] * 2 + [[2, 2, 2]] * 16 + [[2, 0, 0]] * 2


def test_as_many_are_right_as_can_be() -> None:
    rng = np.random.default_rng(0)
    for _ in range(60):
        truth, said = (some(rng, int(rng.integers(1, 5))) for _ in range(2))
        few, many = sorted((truth, said), key=lambda each: len(each.ids))
        fits = iou(few.boxes[:, None], many.boxes) >= 0.5
        best = max(
            sum(fits[i, j] for i, j in enumerate(order))
            for order in permutations(range(len(many.ids)), len(few.ids))
        )
        assert zhao_pei_figure9.count_accurate(truth, said) == (len(truth.ids), len(said.ids), best)


def some(rng: np.random.Generator, count: int) -> MotRows:
    """Return so many boxes in one frame, near to each other."""
    return rows(*((1, i, *rng.integers(0, 8, 2), 20, 20) for i in range(count)))


@pytest.mark.slow
def test_many_objects_on_the_command_line(
    tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    folder, out = write_crowd(tmp_path / "film"), tmp_path / "out"
    line = ["experiment", "zhao-figure9", str(folder), "--out", str(out)]
    assert main(line) == 0, capfd.readouterr().err
    assert sorted(path.name for path in out.iterdir()) == [
        "zhao-figure9-all.csv",
        *(f"zhao-figure9.{ending}" for ending in ("csv", "md", "png")),
    ]
    table = read_csv(out / "zhao-figure9.csv")
    assert [row["ratio"] for row in table] == ["0"] * 2 + ["1"] * 10 + ["0.833333"]
    (row,) = read_csv(out / "zhao-figure9-all.csv")
    assert (row["found by"], row["ratio"]) == ("det.txt", "0.833333")
    assert main([*line, "--overwrite", "--detector", str(folder / "gt" / "gt.txt")]) == 0


def test_lookalikes_are_associated_as_motes_watch_does(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    overlaps: list[float] = []

    def figure9(_: MotSequence, scene: Scene, found_by: str) -> Iterator[Result]:
        overlaps.append(scene.config.association.overlap)
        yield Result({})

    monkeypatch.setattr(zhao_pei_figure9, "figure9", figure9)
    line = ["experiment", "zhao-figure9", str(write_crowd(tmp_path / "film"))]
    for more in ([], ["--like", "10,10,9,9"]):
        assert main([*line, *more]) == 0
    scenes = scene_config(), scene_config().for_lookalikes()
    assert overlaps == [each.association.overlap for each in scenes]
