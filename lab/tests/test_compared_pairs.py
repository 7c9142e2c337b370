"""Trackers compared with one other on films: what is run, and the intervals and the margin."""

from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pytest

import evaluations
from in_process import work_here
from motes_lab.adapters.registry import TrackerSpec, resolve
from motes_lab.datasets.shortened import ShortSequence, shortened
from motes_lab.finished_jobs import run
from motes_lab.papers.pairs import compared, compared_pairs
from motes_lab.protocols.sot import starts
from motes_lab.runner import Job
from motes_lab.scores import Outcome


def outcomes(shifts: dict[str, Sequence[float]]) -> list[Outcome]:
    """Return results of trackers that are off by a number of pixels on each film."""
    return [
        evaluations.outcome(
            tracker,
            evaluations.sequence(f"film {i}", frames=4),
            evaluations.trace(evaluations.shifted([shift] * 4)),
        )
        for tracker, each in shifts.items()
        for i, shift in enumerate(each)
    ]


@pytest.mark.slow
def test_a_difference_has_an_interval_and_a_margin() -> None:
    shifts: dict[str, Sequence[float]] = {"a": [0, 0, 0], "same": [0, 0, 0], "worse": [5, 5, 6]}
    table = compared(outcomes(shifts), "set", "iou", "")
    first, same, worse = [[cell.text for cell in row] for row in table.rows]
    assert first[:3] == ["set", "3", "a"]
    assert first[5:] == ["–", "–", "–"]
    assert same[5:] == ["+0.000", "+0.000 to +0.000", "yes"]
    gap = np.mean([(20 - s) / (20 + s) - 1 for s in (5, 5, 6)])
    assert worse[5] == f"{gap:+.3f}"
    assert worse[7] == "not shown"


def test_a_small_difference_that_is_not_sure_is_not_alike() -> None:
    """Its mean is within the margin, its interval is not."""
    table = compared(outcomes({"a": [0, 5, 0, 5], "b": [5, 0, 5, 0]}), "set", "iou", "")
    assert [cell.text for cell in table.rows[1]][5:] == ["+0.000", "-0.400 to +0.400", "not shown"]


def job(film: ShortSequence | None, trackers: Sequence[TrackerSpec], seeds: int) -> Job:
    assert film is not None
    return Job.of(trackers, film, starts("ope", film, 0, 0), seeds)


@pytest.mark.slow
def test_passes_are_those_of_a_tracker_alone(tmp_path: Path) -> None:
    """Films are decoded once; a tracker neither sees nor disturbs the others."""
    film = evaluations.sequence(frames=6, source=evaluations.pictures(tmp_path / "Book", 6))
    short = shortened(film, 3, 2)
    trackers, _ = resolve(["nummiaro", "maggio", "mean_shift"])
    together = run(job(short, trackers, 2))
    assert [(each.item.tracker, each.item.seed) for each in together] == [
        *(("nummiaro", 0), ("nummiaro", 1), ("maggio", 0), ("maggio", 1), ("mean_shift", 0))
    ]
    (alone, _) = run(job(short, trackers[1:2], 2))
    assert alone.trace is not None
    assert together[2].trace is not None
    np.testing.assert_array_equal(alone.trace.ellipses, together[2].trace.ellipses)


@pytest.mark.slow
def test_a_film_that_fails_is_a_problem(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    work_here(monkeypatch)
    good = evaluations.sequence("Book", 4, source=evaluations.pictures(tmp_path / "Book", 4))
    bad = evaluations.sequence("Gone", 4, source=tmp_path / "Gone")
    trackers, _ = resolve(["mean_shift", "nummiaro"])
    jobs = [job(shortened(film, 4, 1), trackers, 1) for film in (good, bad)]
    *_, result = compared_pairs(jobs, "set", "iou", "Every frame.")
    assert result.share == 1
    assert [problem.where for problem in result.problems] == [
        "mean_shift, nummiaro on Gone, 2 passes"
    ]
    assert result.tables[""].rows[0][1].text == "1"
