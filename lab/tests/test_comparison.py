"""Comparisons of saved evaluations, against numbers worked out by hand."""

from __future__ import annotations

import csv
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from motes import ConfigError, FormatError, SourceError
from motes_lab.cli import main
from motes_lab.metrics.statistics import unpaired_difference
from motes_lab.report.comparison import comparison, default_reference, optimism, trackers
from motes_lab.report.tables import NO_VALUE, Table
from motes_lab.saved_scores import SavedScores
from motes_lab.scores import COLUMNS

NANO = "cv2:nano=a.onnx,b.onnx"


def saved(folder: Path, values: dict[str, dict[str, list[float]]], protocol: str = "ope") -> Path:
    """Write the results.csv of an evaluation: AUC by tracker, sequence and seed."""
    folder.mkdir()
    with (folder / "results.csv").open("w", newline="") as file:
        rows = csv.DictWriter(file, COLUMNS)
        rows.writeheader()
        for tracker, by_sequence in values.items():
            for sequence, aucs in by_sequence.items():
                for seed, auc in enumerate(aucs):
                    row = {"tracker": tracker, "sequence": sequence, "protocol": protocol}
                    rows.writerow(
                        row | {"seed": seed, "auc": auc, "precision_20": auc / 2, "ece": 1 - auc}
                    )
    return folder


def numbers(table: Table, column: str) -> list[float | None]:
    return [row[table.head.index(column)].value for row in table.rows]


@pytest.fixture
def runs(tmp_path: Path) -> list[Path]:
    """Return a run to choose on, the same with a later version, and one to check on."""
    peers = {"cv2:csrt": {"a": [0.5], "b": [0.7], "c": [0.3]}, NANO: {"a": [0.6], "b": [0.6]}}
    default = {"a": [0.8, 0.9], "b": [0.8, 0.8], "c": [0.6, 0.7]}
    better = {"a": [0.9], "b": [0.8], "c": [0.7]}
    check = {"default": {"x": [0.6], "y": [0.4]}, "cv2:csrt": {"x": [0.5], "y": [0.4]}}
    return [
        saved(tmp_path / "before", {"default": default, **peers}),
        saved(tmp_path / "after", {"default": better, **peers}),
        saved(tmp_path / "check", check),
    ]


def test_trackers_are_compared_on_the_sequences_of_both(runs: list[Path]) -> None:
    table = trackers([SavedScores.load(runs[0])], "cv2:csrt")
    assert [row[1].text for row in table.rows] == ["default", "cv2:nano"]
    assert numbers(table, "sequences") == [3, 2]
    assert numbers(table, "AUC") == pytest.approx([0.7667, 0.6], abs=1e-3)
    assert numbers(table, "AUC of cv2:csrt") == pytest.approx([0.5, 0.6])
    assert numbers(table, "difference") == pytest.approx([0.26667, 0], abs=1e-4)
    assert table.rows[0][-2].text == "+0.100 to +0.350"  # of 0.35, 0.1 and 0.35
    assert numbers(table, "won") == [3, 1]


def test_optimism_is_the_lead_that_is_gone(runs: list[Path]) -> None:
    choice, _, check = map(SavedScores.load, runs)
    (row,) = optimism(choice, [check], "cv2:csrt").rows
    # default: 0.7667 and 0.5; CSRT: 0.5 and 0.45.
    assert [cell.value for cell in row[2:5]] == pytest.approx([0.26667, 0.05, 0.21667], abs=1e-4)
    (other,) = optimism(check, [choice], "cv2:csrt").rows
    assert other[4].value == pytest.approx(-0.21667, abs=1e-4)


def test_the_interval_of_two_groups() -> None:
    """With many values it is that of the normal distribution."""
    rng = np.random.default_rng(1)
    first, second = rng.normal(1, 1, 400), rng.normal(0, 2, 100)
    mean, low, high = unpaired_difference(first, second)
    deviation = np.sqrt(first.var() / 400 + second.var() / 100)
    assert mean == pytest.approx(first.mean() - second.mean())
    assert (low, high) == pytest.approx(
        (mean - 1.96 * deviation, mean + 1.96 * deviation), abs=0.03
    )
    assert np.isnan(unpaired_difference(first, np.ones(1))[1])
    assert np.isnan(unpaired_difference(first, np.zeros(0))).all()


@pytest.mark.parametrize(
    ("names", "reference"),
    [
        (["a b cv2:csrt", "cv2:csrt a"], "cv2:csrt"),
        (["a b cv2:csrt", "b a"], "a"),
        (["a b", "b c"], "b"),
        (["a b", "c"], "a"),  # which the second run is then said not to have
    ],
)
def test_without_the_peer_the_first_tracker_is_the_reference(
    names: list[str], reference: str, tmp_path: Path
) -> None:
    given = [{tracker: {"one": [0.5]} for tracker in each.split()} for each in names]
    folders = [saved(tmp_path / str(index), values) for index, values in enumerate(given)]
    assert default_reference([SavedScores.load(folder) for folder in folders]) == reference


def test_what_does_not_fit_is_refused(tmp_path: Path, runs: list[Path]) -> None:
    first = SavedScores.load(runs[0])
    with pytest.raises(ConfigError, match="no tracker cv2:kcf; it has default, cv2:csrt, cv2:"):
        list(comparison([first], "cv2:kcf"))
    other = SavedScores.load(saved(tmp_path / "moved", {"cv2:csrt": {"a": [1]}}, "pixel"))
    with pytest.raises(ConfigError, match="--protocol"):
        list(comparison([first, other], "cv2:csrt"))
    with pytest.raises(SourceError, match="has no pass of the protocol pixel; it has ope"):
        SavedScores.load(runs[0], "pixel")
    with pytest.raises(SourceError, match="no number in the column od"):
        SavedScores.load(runs[0], column="od")
    for column in ("bogus", "tracker", "error"):
        known = f"no numbers {column}; choose one of frames, auc, .*, ms_95, fps.$"
        with pytest.raises(ConfigError, match=known):
            SavedScores.load(runs[0], column=column)
    with pytest.raises(SourceError, match="give the folder of an evaluation"):
        SavedScores.load(tmp_path)
    (tmp_path / "results.csv").write_text("a,b\n1,2\n")
    with pytest.raises(FormatError, match="not a table of motes-lab evaluate"):
        SavedScores.load(tmp_path)


def test_a_tracker_without_numbers_in_a_column(tmp_path: Path) -> None:
    """It is there all the same: some never lose their target, and have no lost_frame."""
    path = saved(tmp_path / "run", {"sure": {"a": [0.5]}, "lost": {"a": [0.25]}}) / "results.csv"
    path.write_text(path.read_text().replace(",0.5,", ",,", 1))
    run = SavedScores.load(path.parent)
    with pytest.raises(ConfigError, match="has no number auc of sure; choose another --reference"):
        list(comparison([run], "sure"))
    (row,) = trackers([run], "lost").rows
    assert [cell.text for cell in row[1:]] == ["sure", "0", *[NO_VALUE] * 4, "0 of 0"]


@pytest.mark.parametrize(
    "damage",
    [
        lambda text: text[: len(text) // 2],
        lambda text: text[:-1],
        lambda text: text + text.splitlines(keepends=True)[-1],
        lambda text: text.replace("\n", ",9\n").replace(",9\n", "\n", 1),
        lambda text: text.replace("0.", "1e999", 1),
        lambda text: text.replace("0.", "nan", 1),
    ],
    ids=["half", "its last line end", "a pass twice", "a field more", "infinite", "no number"],
)
def test_damaged_results_are_refused(damage: Callable[[str], str], runs: list[Path]) -> None:
    path = runs[0] / "results.csv"
    text = path.read_text()
    assert damage(text) != text
    path.write_text(damage(text))
    with pytest.raises(FormatError, match="or is damaged; make it again"):
        SavedScores.load(runs[0])


def test_compare_on_the_command_line(
    runs: list[Path], tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    out = tmp_path / "out"
    assert main(["compare", *map(str, runs), "--out", str(out)]) == 0
    printed = capfd.readouterr().out
    assert all(title in printed for title in ("Compared with cv2:csrt", "Optimism of"))
    assert {path.name for path in out.iterdir()} == {
        "compare.md",
        "compare-trackers.csv",
        "compare-versions.csv",
        "compare-optimism.csv",
    }
    assert main(["compare", str(runs[0])]) == 0
    assert "Optimism" not in capfd.readouterr().out
    assert main(["compare", str(tmp_path / "nothing")]) == 3
