"""The results of an evaluation as its jobs end, for experiments that keep no tracks."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Generic, NamedTuple

from motes.cluster.local import LocalPool
from motes.cluster.pool import TIME_LIMIT
from motes.core.errors import SourceError
from motes_lab import runner
from motes_lab.adapters.registry import TrackerSpec
from motes_lab.datasets.mot import MotSequence
from motes_lab.datasets.sot import Problem
from motes_lab.datasets.sot import Sequence as Film
from motes_lab.runner import Pass
from motes_lab.scores import E


class Finished(NamedTuple, Generic[E]):
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

    outcomes: list[E]
    problems: list[Problem]
    progress: str


def finished_passes(
    kind: type[E],
    entries: Sequence[TrackerSpec],
    films: Sequence[Film] | Sequence[MotSequence],
    seeds: int,
    workers: int,
) -> Iterator[Finished[E]]:
    """Run trackers over sequences in worker processes and yield the results after each job.

    Parameters
    ----------
    kind
        `Outcome` for sequences of one object, `MotOutcome` for those of many.
    entries, films, seeds, workers
        The trackers, the sequences, and the numbers of seeds and of processes.

    Raises
    ------
    SourceError
        If no sequence can be opened.
    """
    jobs, unreadable = runner.plan(entries, films, ["ope"], seeds)
    if not jobs:
        raise SourceError(f"No sequence can be used. {unreadable[0].where}: {unreadable[0].what}")
    outcomes: list[E] = []
    with TemporaryDirectory(prefix="motes-") as folder:
        out, errors, done = Path(folder), dict[Pass, str](), 0
        with LocalPool(workers) as pool:
            for job, failed in runner.run(pool, jobs, out, TIME_LIMIT):
                if failed is not None:
                    errors |= failed
                    outcomes += kind.of(job, out, errors)
                    done += 1
                    progress = f"{done} of {len(jobs)} jobs, last {job.name}"
                    yield Finished(outcomes, unreadable, progress)
