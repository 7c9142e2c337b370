"""Choosing on some sequences and reporting on others; speed on each sequence beside a peer's."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from evaluations import outcome, sequence, shifted, trace
from motes_lab.aggregate import Evaluation
from motes_lab.protocols.trace import TrackerOutput
from motes_lab.report.cross_validation import choices, choose, split
from motes_lab.report.sections import recovery
from motes_lab.report.speed_ratio import Comparisons, speed_ratios
from motes_lab.report.tables import NO_VALUE, Table
from motes_lab.report.write import write_report
from motes_lab.scores import Outcome

UNIT = 20 / 21
"""AUC of a track that fits in all frames."""


def said(good: int, seconds: float = 0.002) -> TrackerOutput:
    """Return a trace that is right in so many of 20 frames."""
    return trace(shifted([0.0] * good + [90.0] * (20 - good)), seconds=seconds)


def texts(table: Table) -> list[list[str]]:
    return [[cell.text for cell in row] for row in (*table.rows, *table.foot)]


# Folds


def test_folds_go_by_name() -> None:
    assert split(["e", "b", "d", "a", "c"], 2) == [["a", "c", "e"], ["b", "d"]]
    assert split(["b", "a"], 2) == [["a"], ["b"]]


def test_a_choice_that_does_not_hold() -> None:
    """What is best on one half is worst on the other."""
    values = {
        "lucky": {"a": 0.9, "b": 0.1, "c": 0.7, "d": 0.3},
        "steady": {"a": 0.5, "b": 0.5, "c": 0.5, "d": 0.4},
    }
    first, second = choose(values, 2)
    assert tuple(first) == (["a", "c"], "steady", pytest.approx(0.45), 0.5)
    assert tuple(second) == (["b", "d"], "lucky", pytest.approx(0.8), pytest.approx(0.2))


def test_choices_against_a_second_implementation() -> None:
    rng = np.random.default_rng(0)
    table = rng.uniform(size=(4, 11))
    values = {str(i): {f"{j:02d}": float(v) for j, v in enumerate(r)} for i, r in enumerate(table)}
    for k, fold in enumerate(choose(values, 3)):
        out = np.arange(11) % 3 == k
        best = int(np.argmax(table[:, ~out].mean(axis=1)))
        assert fold.chosen == str(best)
        assert fold.inside == pytest.approx(table[best, ~out].mean())
        assert fold.outside == pytest.approx(table[best, out].mean())


def trackers() -> list[Outcome]:
    """Return two configurations and two peers, of which one fails, on five sequences."""
    goods = {"one": [18, 2, 14, 6], "two": [10, 10, 10, 8], "cv2:csrt": [20, 12, 16, 4]}
    found = []
    for name, numbers in goods.items():
        for where, good in zip("abcd", numbers, strict=True):
            found.append(outcome(name, sequence(where), said(good)))
    found.append(outcome("one", sequence("e"), said(20)))
    found.append(outcome("two", sequence("e"), "broken"))
    found += [outcome("cv2:kcf", sequence(where), said(20)) for where in "bd"]
    return found


def test_the_table_of_folds() -> None:
    table = choices(Evaluation(trackers()), "ope", ["one", "two"], 2)
    assert table.head[2:] == (
        *("chosen", "AUC chosen on", "AUC left out", "difference", "cv2:csrt", "cv2:kcf"),
    )
    a, b, c = (f"{UNIT * value:.3f}" for value in (0.45, 0.5, 0.05))
    d, e, f = (f"{UNIT * value:.3f}" for value in (0.8, 0.2, -0.6))
    assert texts(table) == [
        ["1", "2", "two", a, b, c, f"{UNIT * 0.9:.3f}", NO_VALUE],
        ["2", "2", "one", d, e, f, f"{UNIT * 0.4:.3f}", f"{UNIT:.3f}"],
        [
            *("mean", "4", ""),
            *(f"{UNIT * value:.3f}" for value in (0.625, 0.35, -0.275, 0.65)),
            NO_VALUE,
        ],
    ]


# Times


def test_how_many_times_as_fast() -> None:
    places = [sequence("a"), sequence("b"), sequence("c")]
    times = {"cv2:csrt": (0.03, 0.02, 0.01), "fast": (0.01, 0.005, 0.005), "odd": (0.06, 0.0, 0)}
    outcomes = [
        outcome(name, where, said(20, each))
        for name, numbers in times.items()
        for where, each in zip(places, numbers, strict=True)
    ]
    outcomes[5] = outcome("fast", places[2], "broken")
    # The median is over all updates of all seeds.
    outcomes += [outcome("fast", places[0], said(20, 0.02), seed) for seed in (1, 2)]
    table = speed_ratios(Evaluation(outcomes), "ope", "cv2:csrt")
    assert table.head == ("sequence", "fast", "odd")
    assert texts(table) == [
        ["a", "1.50", "0.500"],
        ["b", "4.00", NO_VALUE],
        ["c", NO_VALUE, NO_VALUE],
        ["minimum", "1.50", "0.500"],
    ]


# Losses, and the report


def test_the_table_of_losses() -> None:
    dx = [0.0, *[90.0] * 40, 0.0, *[90.0] * 40]
    runs = [
        outcome("a", sequence(frames=82), trace(shifted(dx), covariance=(1, 0, 1))),
        outcome("b", sequence(frames=82), trace(shifted([0.0] * 82))),
    ]
    table = recovery(Evaluation(runs), "ope")
    assert texts(table) == [
        ["a", "2", "0.500", "81", f"{1 / 81:.3f}"],
        ["b", "0", NO_VALUE, "0", NO_VALUE],
    ]
    again = [outcome("a", one.sequence, one.trace or "", 0, "reset") for one in runs[:1]]
    assert texts(recovery(Evaluation(again), "reset")) == [["a", "81", f"{1 / 81:.3f}"]]


@pytest.mark.slow
def test_the_report_has_what_is_wanted(tmp_path: Path) -> None:
    titles = ["Model selection by cross-validation, 2 folds", "Speed relative to cv2:csrt"]
    for wanted, there in (
        (Comparisons(), [False, True]),
        (Comparisons(peer="nobody", candidates=("one", "two"), folds=2), [True, False]),
    ):
        write_report(tmp_path, trackers(), [], wanted, "Some")
        for name in ("report.html", "summary.md"):
            text = (tmp_path / name).read_text(encoding="utf-8")
            assert [title in text for title in titles] == there
            assert "Recovery after losses, and covariance" in text
