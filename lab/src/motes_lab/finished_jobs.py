"""The results of jobs in memory, as they end, for experiments that keep no tracks."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any

from motes_fleet.cluster import pool as pools
from motes_fleet.cluster.machine import cores
from motes_fleet.cluster.open_pool import open_pool
from motes_lab.datasets.mot import MotSequence
from motes_lab.mot_scores import MotOutcome
from motes_lab.runner import Job, Pass, feed
from motes_lab.scores import Outcome

Results = list[Any]
"""An `Outcome` or `MotOutcome` for each pass."""


def finished_jobs(jobs: Sequence[Job]) -> Iterator[tuple[Results, str, float]]:
    """Run jobs in a process for each core; yield the results of each, progress and done share."""
    with open_pool(None, cores()) as pool:
        events = pools.run(
            pool, (pools.Task(job.name, run, job, seconds=pools.TIME_LIMIT) for job in jobs)
        )
        for done, event in enumerate((each for each in events if isinstance(each, pools.Ended)), 1):
            job: Job = event.task.argument
            if event.error is None:
                results: Results = event.value
            else:
                results = [_result(job, item, None, event.error) for item in job.passes]
            yield results, f"{done} of {len(jobs)} jobs, last {job.name}", done / len(jobs)


def run(job: Job) -> Results:
    """Run the passes of a job, which share its frames, and return their results."""
    ended, errors = feed(job, shared=True)
    return [
        _result(job, item, None, errors[item])
        if item in errors
        else _result(job, item, ended[item].trace)
        for item in job.passes
    ]


def _result(job: Job, item: Pass, trace: Any, error: str = "") -> Any:
    kind: type[Any] = MotOutcome if isinstance(job.sequence, MotSequence) else Outcome
    return kind(job.sequence, item, trace, error)
