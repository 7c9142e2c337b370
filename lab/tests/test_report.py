"""The report: what is in it, and that names stay names."""

import re
from pathlib import Path

import numpy as np
import pytest

from evaluations import outcome, sequence, shifted, trace
from motes_lab.aggregate import Evaluation
from motes_lab.datasets.sot import Problem
from motes_lab.protocols.trace import TrackerOutput
from motes_lab.report import sections
from motes_lab.report.markdown import write_report
from motes_lab.report.tables import best, number
from motes_lab.scores import PROTOCOL_NAMES, Outcome

NASTY = "<script>alert(1)</script> $x$ | `y` _z & \"q\" 'r'"


def report(
    folder: Path, outcomes: list[Outcome], problems: list[Problem], title: str = "Some trackers"
) -> str:
    """Write a report; return its text without escapes, checked as every report is."""
    found = Evaluation(outcomes)
    tables = {PROTOCOL_NAMES[name]: sections.tables(found, name) for name in found.protocols}
    folder.mkdir()
    problems = sections.problems(problems, outcomes)
    write_report(folder, found, tables, problems, title)
    (path,) = folder.iterdir()
    text = path.read_text(encoding="utf-8")
    for block in text.split("\n\n"):
        if block.startswith("|"):
            rows = [re.split(r"(?<!\\)\|", line)[1:-1] for line in block.splitlines()]
            assert len({len(row) for row in rows}) == 1
            assert set("".join(rows[1])) <= set(" -")
    assert not re.search(r"\bnan\b|\bNone\b|\binf\b", text)
    assert "<" not in re.sub(r"\\.", "", text)
    return text.replace("\\", "")


def said(share: float, sure: bool = True) -> TrackerOutput:
    """Return a trace that is right for a share of the frames."""
    good = round(share * 20)
    boxes = shifted([0.0] * good + [90.0] * (20 - good))
    confidence = [0.9] * good + [0.2] * (20 - good) if sure else np.nan
    return trace(boxes, confidence, [False] * good + [True] * (20 - good))


def full() -> list[Outcome]:
    """Return three trackers on three sequences; one tracker fails."""
    outcomes = []
    for name in ("Book", "Ant", "Gone"):
        where = sequence(name)
        for seed in range(3):
            outcomes.append(outcome("ours", where, said(0.7 + seed / 10), seed))
        outcomes.append(outcome(NASTY, where, said(0.4, sure=False)))
        third = "It broke <here>." if name == "Ant" else said(0.55)
        outcomes.append(outcome("_third", where, third))
    return outcomes


def test_report(tmp_path: Path) -> None:
    problems = [Problem("sequence <Cow>", "the frame 7 is missing")]
    text = report(tmp_path / "out", full(), problems, "Trackers & <others>")
    for words in (
        *("ours", NASTY, "_third", "Book", "Ant", "Gone"),
        "# Trackers & <others>",
        "3 trackers on 3 sequences, 3 seeds for stochastic trackers.",
        "Passes: 15 ope; 1 of them failed.",
        "| sequence <Cow> | the frame 7 is missing |",
        "| _third on Ant, ope, seed 0 | It broke <here>. |",
    ):
        assert words in text
    auc = 20 / 21
    ours = f"**{0.8 * auc:.3f} ± {0.1 * auc:.3f}**"
    assert f"| ours | 3 of 3 | {ours} |" in text
    assert f"| _third | 2 of 3 | {0.55 * auc:.3f} |" in text
    assert f"| Ant | {ours} | {0.4 * auc:.3f} | failed |" in text
    difference = (0.4 - 0.8) * auc
    assert f"| {difference:+.3f} | {difference:+.3f} to {difference:+.3f} | 0 of 3 | 0 |" in text
    # Every tracker says that it is lost exactly where it is.
    assert text.count("| 1.000 | 1.000 | 1.000 |") == 3 - 1  # with one seed
    assert "| 1.000 ± 0.000 | 1.000 ± 0.000 | 1.000 ± 0.000 |" in text


@pytest.mark.slow
@pytest.mark.parametrize(
    "outcomes",
    [
        [],
        [outcome("a", sequence(), said(1))],
        [outcome("a", sequence(), said(0.5, sure=False))],
        [outcome("a", sequence(), "broken"), outcome("b", sequence(), "broken")],
        [outcome("a", sequence(), "broken"), outcome("b", sequence(), said(0.3))],
        [outcome("a", sequence(frames=1), trace(shifted([0]), 0.5))],
        [outcome("a", sequence(frames=0), trace(shifted([])))],
        [outcome("a", sequence(frames=3, absent=[0, 1, 2]), trace(shifted([0, 0, 0]), 0.5))],
        [outcome("a", sequence(frames=3), trace(shifted([0, 0, 0]), [np.nan, 0.5, np.nan]))],
        [outcome("a", sequence(frames=3), trace(shifted([np.nan] * 3)))],
        [outcome("a", sequence(frames=3), trace(shifted([0] * 3), seconds=0))],
        [outcome(name, sequence(), said(0.5), 0, "pixel", "+1") for name in "ab"],
    ],
    ids=[
        *("nothing", "one", "no confidence", "all failed", "first failed", "a start alone"),
        *("no frames", "no target", "some confidence", "no regions", "no time", "moved"),
    ],
)
def test_reports_of_odd_runs(tmp_path: Path, outcomes: list[Outcome]) -> None:
    text = report(tmp_path / "out", outcomes, [])
    for one in outcomes:
        assert f"| {one.item.tracker} |" in text
        assert one.item.sequence in text


def test_a_score_of_nothing_is_not_the_best() -> None:
    """Trackers that report no loss have an F1 of 0, and none where nothing was lost."""
    assert not any(cell.best for cell in best([number(0.0), number(0.0), number(None)]))
    assert [cell.best for cell in best([number(0.0), number(0.2), number(None)])] == [
        False, True, False,
    ]  # fmt: skip
    assert [cell.best for cell in best([number(0.0), number(0.2)], -1)] == [True, False]
