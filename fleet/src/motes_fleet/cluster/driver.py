"""The driver of a batch: which jobs are left, their attempts, and what became of them.

It holds few of the jobs, however many wait: they are read from their table as workers become free.
What is done is known from the records in the store alone, so a driver that is started again goes on
where the other one was killed.
"""

from __future__ import annotations

from collections.abc import Callable, Generator, Iterable, Iterator

from msgspec.structs import replace

from motes import FormatError, MotesError
from motes_fleet.cluster import pool as pools
from motes_fleet.cluster.inputs import InputFile, changed, paths_of, stamp
from motes_fleet.cluster.jobs import Job
from motes_fleet.cluster.records import (
    Record,
    encoded,
    read_record,
    record_name,
    records,
    result_names,
)
from motes_fleet.cluster.store import Store
from motes_fleet.cluster.work import Plan, work

BatchEvent = Record | pools.Started | pools.Again
"""What becomes of a job: in the end it has a record."""


def batch(
    pool: pools.Pool, store: Store, jobs: Iterable[Job], plan: Plan, keep: Callable[[Record], None]
) -> Generator[BatchEvent, None, None]:
    """Do the jobs that are left; yield what becomes of each.

    Parameters
    ----------
    pool
        The workers; the caller closes it.
    store
        The store at `plan.out`; the caller keeps other batches out.
    jobs
        All jobs; each is taken when a worker will be free for it.
    plan
        How they are done.
    keep
        Takes the record of each job that needs nothing: it is there, and its inputs are the same.

    Raises
    ------
    FormatError
        If the store cannot be written, or a worker writes to another one.
    """
    for event in pools.run(pool, _tasks(store, jobs, plan, keep), plan.attempts):
        if isinstance(event, pools.Started | pools.Again):
            yield event
        else:
            yield _settled(store, event, plan)


def _tasks(
    store: Store, jobs: Iterable[Job], plan: Plan, keep: Callable[[Record], None]
) -> Iterator[pools.Task]:
    """Yield the tasks of the jobs that are left; give the records of the others to `keep`."""
    for job, record in records(store, jobs):
        if record is not None:
            if not _outdated(record, job, plan):
                keep(record)
                continue
            # The record goes first: without it, what is left of the results does not count.
            for name in (record_name(job.name), *result_names(job.name)):
                store.remove(name)
        yield pools.Task(job.name, work, (job, plan), plan.time_limit)


def _outdated(record: Record, job: Job, plan: Plan) -> bool:
    """Return whether a job has to be done again."""
    if record.digest != plan.new_record(job).digest or (record.status == "failed" and plan.again):
        return True
    return changed(record.inputs)


def _settled(store: Store, event: pools.Ended, plan: Plan) -> Record:
    """Return the record of a job that has ended, and see that it is in the store."""
    job: Job = event.task.argument[0]
    record: Record | None = event.value
    if record is None:
        record = replace(plan.new_record(job), inputs=_stamped(job), error=event.error)
    if record.status == "done" and event.task.attempt == 1:
        if read_record(store, record.name) is None:
            raise FormatError(
                f"A worker on {record.host} wrote the results of {record.name}, but they are not "
                f"in {plan.out}; give a folder that all nodes see, or an address such as s3://…"
            )
        return record
    record = replace(record, attempts=event.task.attempt)
    store.write(record_name(record.name), encoded(record))
    return record


def _stamped(job: Job) -> tuple[InputFile, ...]:
    """Return the inputs of a job that nobody could finish, so that changed ones are tried again."""
    try:
        return tuple(InputFile(path, stamp(path), "") for path in paths_of(job))
    except MotesError:  # as of a server that does not answer
        return ()
