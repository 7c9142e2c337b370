"""How the jobs of a batch are done, and the one function that does one, wherever its worker is."""

from __future__ import annotations

import socket
import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from msgspec.structs import replace

from motes import FormatError, MotesError, SourceError, __version__
from motes_fleet.cluster import pool as pools
from motes_fleet.cluster.inputs import changed, localized
from motes_fleet.cluster.jobs import Job
from motes_fleet.cluster.objects import StoreError
from motes_fleet.cluster.records import Record, encoded, place_of, record_name
from motes_fleet.cluster.store import open_store

Made = tuple[int, str | None]
"""What a job has made: the number of frames that it used; and what was strange, in one line."""


@dataclass(frozen=True)
class Plan:
    """How the jobs of a batch are done."""

    out: str
    """The address of the store."""
    make: Callable[[Job, Path, str, bool], Made]
    """Writes the results of a job, whose files are on this machine, into a folder: `rows.*`,
    `events.*` and `overlay.*`. It is a function at the top level of a module."""
    form: str = "csv"
    """The ending of the rows: csv or parquet."""
    overlay: bool = False
    """Whether an annotated video is made."""
    attempts: int = pools.ATTEMPTS
    """How often a job whose worker dies is tried."""
    time_limit: float = pools.TIME_LIMIT
    """Seconds for an attempt."""
    again: bool = False
    """Whether jobs that have failed are tried again."""

    def new_record(self, job: Job) -> Record:
        """Return the record of a job that has no results yet."""
        digest = job.digest(self.form, self.overlay)
        return Record(name=job.name, status="failed", digest=digest, version=__version__)


def work(order: tuple[Job, Plan]) -> Record:
    """Do a job as planned; return its record, which is in the store already if the job is done.

    Results get their names when all are made, and the record comes last: without it, what is left
    of an attempt does not count.

    Raises
    ------
    TryAgain
        If a server or the network fails.
    FormatError
        If the store cannot be written.
    """
    begun, (job, plan) = time.perf_counter(), order
    store = open_store(plan.out)
    record = replace(plan.new_record(job), host=socket.gethostname())
    with store.scratch() as scratch:
        made = Path(scratch) / "made"
        made.mkdir()
        try:
            here, inputs = localized(job, Path(scratch) / "inputs")
            record = replace(record, inputs=inputs)
            frames, note = plan.make(here, made, plan.form, plan.overlay)
            if changed(inputs):
                raise SourceError("An input has changed while it was read; start again.")
        except StoreError:
            raise
        except MotesError as error:
            return replace(record, seconds=_since(begun), error=_reason(error))
        for path in sorted(made.iterdir()):
            store.write(place_of(job.name, path.name), path)
    record = replace(record, status="done", frames=frames, error=note, seconds=_since(begun))
    store.write(record_name(job.name), encoded(record))
    return record


def _reason(error: MotesError) -> str:
    """Return why a job has failed.

    A command whose disk is full says what it has kept, and where: here that goes with the folder.
    """
    cause = error.__cause__
    if isinstance(error, FormatError) and isinstance(cause, OSError):
        return f"Its results cannot be written: {cause.strerror}; make room."
    return str(error)


def _since(begun: float) -> float:
    return round(time.perf_counter() - begun, 3)
