"""Speed on each sequence beside a peer's, and losses."""

from __future__ import annotations

from pathlib import Path

import pytest

from evaluations import outcome, sequence, shifted, trace
from motes_lab.aggregate import Evaluation
from motes_lab.protocols.trace import TrackerOutput
from motes_lab.report.sections import recovery
from motes_lab.report.speed_ratio import Comparisons, speed_ratios
from motes_lab.report.tables import NO_VALUE, Table
from motes_lab.report.write import write_report
from motes_lab.scores import Outcome


def said(good: int, seconds: float = 0.002) -> TrackerOutput:
    """Return a trace that is right in so many of 20 frames."""
    return trace(shifted([0.0] * good + [90.0] * (20 - good)), seconds=seconds)


def texts(table: Table) -> list[list[str]]:
    return [[cell.text for cell in row] for row in (*table.rows, *table.foot)]


def trackers() -> list[Outcome]:
    """Return the passes of four trackers on five sequences, of which one fails."""
    goods = {"one": [18, 2, 14, 6], "two": [10, 10, 10, 8], "cv2:csrt": [20, 12, 16, 4]}
    found = []
    for name, numbers in goods.items():
        for where, good in zip("abcd", numbers, strict=True):
            found.append(outcome(name, sequence(where), said(good)))
    found.append(outcome("one", sequence("e"), said(20)))
    found.append(outcome("two", sequence("e"), "broken"))
    found += [outcome("cv2:kcf", sequence(where), said(20)) for where in "bd"]
    return found


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
@pytest.mark.parametrize("peer", ["cv2:csrt", "nobody"])
def test_the_report_has_what_is_wanted(tmp_path: Path, peer: str) -> None:
    write_report(tmp_path, trackers(), [], Comparisons(peer=peer), "Some")
    for name in ("report.html", "summary.md"):
        text = (tmp_path / name).read_text(encoding="utf-8")
        assert ("Speed relative to cv2:csrt" in text) == (peer == "cv2:csrt")
        assert "Recovery after losses, and covariance" in text
