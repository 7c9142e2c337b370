"""Texts of others in tables: no formulas, and the same text when they are read again."""

import csv
from pathlib import Path

import pytest
from hypothesis import given, strategies as st

from motes.core.geometry import Ellipse
from motes.core.labels import MARKS, guarded, unguarded
from motes.formats import registry
from motes.formats.recording import Recording
from motes_fleet.cluster import state
from motes_lab import scores
from recordings import FACTS, placed

FORMULAS = ['=HYPERLINK("http://x",A1)', "+1+cmd|' /C calc'!A0", "-2+3", "@SUM(1)", "\t=1", "'=1"]


@pytest.mark.slow
@given(st.text(alphabet="'=+-@1ae.\t", max_size=6))
def test_a_text_comes_back_and_is_no_formula(text: str) -> None:
    cell = guarded(text)
    assert unguarded(cell) == text
    if cell.startswith(MARKS):
        assert float(cell) == float(text)  # a number, which is none either


@pytest.mark.parametrize("name", FORMULAS[::3])
def test_names_of_classes_are_no_formulas(name: str, tmp_path: Path) -> None:
    place = Ellipse.from_box((-9, 9, 20, 30))
    rows = Recording.of(FACTS, [placed(0, place, label=name)])
    registry.write(tmp_path / "a.csv", "csv", rows)
    last = (tmp_path / "a.csv").read_text().splitlines()[-1]
    assert "-9.000,9.000" in last  # and numbers are as they were
    assert last.removeprefix("0,0.000000,1,").lstrip('"').startswith("'")
    row, *_ = registry.read(tmp_path / "a.csv", "csv", FACTS)
    assert row.objects[0].label == name


@pytest.mark.parametrize("name", FORMULAS)
def test_names_of_films_and_trackers_are_no_formulas(name: str, tmp_path: Path) -> None:
    state._write_csv(tmp_path / "jobs.csv", iter([{"job": name, "label": name, "frames": -1}]))
    scores.write_table(tmp_path / "results.csv", ["tracker", "mota"], [[name, "-0.25"]])
    for file in ("jobs.csv", "results.csv"):
        with (tmp_path / file).open(newline="") as lines:
            _, cells = csv.reader(lines)
        assert cells[0] == f"'{name}"
        assert not any(cell.startswith(MARKS) for cell in cells if cell not in ("-1", "-0.25"))
        assert {"-1", "-0.25"} & set(cells)
