"""The weight of orientation on film: the parts that are compared, and where they come from."""

import itertools
from pathlib import Path

import numpy as np
import pytest

import evaluations
from motes import ConfigError
from motes_lab.papers.maggio_figure3 import Marks, figure3, sharpness_of

TRUTH = Path(__file__).parent / "truth" / "covered.toml"


def test_the_marks_by_eye() -> None:
    marks = Marks.load(TRUTH)
    parts = sorted([*marks.covered, *marks.clear])
    assert all(first <= last for first, last in parts)
    assert all(one[1] < other[0] for one, other in itertools.pairwise(parts))
    for text in ("covered = [[1, 2], [3, 4]]", "covered = [[1]]\nclear = [[1, 2], [5, 6]]"):
        with pytest.raises(ConfigError):
            Marks.parse(text)


def test_a_blurred_region_is_less_sharp() -> None:
    rng = np.random.default_rng(0)
    pixels = rng.integers(0, 256, (40, 40, 3), np.uint8)
    soft = (pixels.astype(float) + np.roll(pixels, 1, axis=1) + np.roll(pixels, 1, axis=0)) / 3
    box = np.array([-5.0, 5, 30, 20])
    assert sharpness_of(soft.astype(np.uint8), box) < 0.5 * sharpness_of(pixels, box)


@pytest.mark.slow
def test_marked_parts_are_compared(tmp_path: Path) -> None:
    film = evaluations.sequence(frames=8, source=evaluations.pictures(tmp_path / "Book", 8))
    marks = Marks(covered=((0, 1), (2, 3)), clear=((4, 5), (6, 7)))
    names = ["maggio:printed", "maggio"]
    *_, result = figure3(names, film, marks, "size", 2)
    table = result.tables[""]
    assert table.head[3:7] == ("covered parts", "clear parts", "covered", "clear")
    _, fixed = table.rows
    assert [cell.text for cell in fixed[1:3]] == ["maggio", "2"]
    assert [cell.text for cell in fixed[3:8]] == ["2", "2", "0.34", "0.34", "+0.00"]
