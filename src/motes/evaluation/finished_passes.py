"""The results of an evaluation as its jobs end, for experiments that keep no tracks."""

from __future__ import annotations

import contextlib
from collections.abc import Iterator, Sequence
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import NamedTuple

from motes.core.errors import SourceError
from motes.evaluation import runner
from motes.evaluation.adapters.registry import TrackerSpec
from motes.evaluation.datasets.sot import Problem
from motes.evaluation.datasets.sot import Sequence as Film
from motes.evaluation.runner import Pass
from motes.evaluation.scores import Outcome


class Finished(NamedTuple):
    """The results after a job.

    Attributes
    ----------
    outcomes
        All results so far.
    problems
        Films that cannot be read.
    progress
        Number of finished jobs, as text.
    """

    outcomes: list[Outcome]
    problems: list[Problem]
    progress: str


def finished_passes(
    entries: Sequence[TrackerSpec], films: Sequence[Film], seeds: int, workers: int
) -> Iterator[Finished]:
    """Run trackers over sequences in worker processes and yield the results after each job.

    Raises
    ------
    SourceError
        If no sequence can be opened.
    """
    jobs, unreadable = runner.plan(entries, films, ["ope"], seeds)
    if not jobs:
        raise SourceError(f"No sequence can be used. {unreadable[0].where}: {unreadable[0].what}")
    outcomes: list[Outcome] = []
    with TemporaryDirectory(prefix="motes-") as folder:
        out, errors, done = Path(folder), dict[Pass, str](), 0
        with contextlib.closing(runner.run(jobs, out, workers, runner.TIME_LIMIT)) as steps:
            for job, failed in steps:
                if failed is not None:
                    errors |= failed
                    outcomes += Outcome.of(job, out, errors)
                    done += 1
                    progress = f"{done} of {len(jobs)} jobs, last {job.name}"
                    yield Finished(outcomes, unreadable, progress)
