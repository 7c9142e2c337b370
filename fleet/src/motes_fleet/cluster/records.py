"""Records: what became of each job; a job is done when its record is there.

OUT/jobs.jsonl               the jobs, a line for each
OUT/jobs/NAME.json           the record of a job
OUT/rows/job=NAME/...        its rows; a dataset of Parquet that is partitioned by job
OUT/events/job=NAME/...      its events, OUT/overlays/NAME.mp4 its annotated video
OUT/jobs.parquet             all records as a table, at the end of a run
"""

from __future__ import annotations

import hashlib
from collections.abc import Iterable, Iterator
from itertools import islice
from typing import Literal
from urllib.parse import quote

import msgspec

from motes import FormatError
from motes_fleet.cluster.inputs import InputFile
from motes_fleet.cluster.jobs import Job
from motes_fleet.cluster.store import Store

TOGETHER = 500
"""Records that are read at the same time."""
LONGEST_NAME = 120
"""Longest name of `slug`; longer names are cut and get a digest, so that they stay different."""


class Record(msgspec.Struct, frozen=True, kw_only=True):
    """What became of a job."""

    name: str
    status: Literal["done", "failed"]
    """The job, and whether it has results."""
    digest: str
    """That of the job and of the options of the batch."""
    attempts: int = 1
    seconds: float = 0.0
    frames: int = 0
    """How often it was tried, how long the last attempt took, and how many frames it used."""
    host: str = ""
    version: str = ""
    """The machine, and the version of motes."""
    inputs: tuple[InputFile, ...] = ()
    """The files that were read, the source first."""
    error: str | None = None
    """Why there are no results, in one line; or what was strange."""


def slug(name: str) -> str:
    """Return a name for a file or folder, a different one for each text."""
    quoted = quote(name, safe="+")
    if len(quoted) <= LONGEST_NAME:
        return quoted
    return f"{quoted[:LONGEST_NAME]}%{hashlib.sha256(name.encode()).hexdigest()[:16]}"


def record_name(job: str) -> str:
    """Return the name of a job's record."""
    return f"jobs/{slug(job)}.json"


def result_names(job: str) -> list[str]:
    """Return the files and folders of a job's results."""
    name = slug(job)
    return [f"rows/job={name}", f"events/job={name}", f"overlays/{name}.mp4"]


def place_of(job: str, file: str) -> str:
    """Return where a file that a job has made goes: `rows.csv`, `events.jsonl`, `overlay.mp4`."""
    kind, _, ending = file.partition(".")
    if kind == "overlay":
        return f"overlays/{slug(job)}.{ending}"
    return f"{kind}/job={slug(job)}/{file}"


def read_record(store: Store, job: str) -> Record | None:
    """Return the record of a job; None if there is none."""
    name = record_name(job)
    data = store.read([name]).get(name)
    return None if data is None else _record(name, data)


def records(store: Store, jobs: Iterable[Job]) -> Iterator[tuple[Job, Record | None]]:
    """Yield each job with its record, or None; few of them are in memory.

    Raises
    ------
    FormatError
        If a record is damaged.
    """
    known, left = set(store.names("jobs")), iter(jobs)
    while some := list(islice(left, TOGETHER)):
        names = {job.name: record_name(job.name) for job in some}
        there = [name for name in names.values() if name.removeprefix("jobs/") in known]
        found = store.read(there)
        for job in some:
            data = found.get(names[job.name])
            yield job, None if data is None else _record(names[job.name], data)


def _record(name: str, data: bytes) -> Record:
    try:
        return msgspec.json.decode(data, type=Record)
    except msgspec.MsgspecError as error:
        raise FormatError(f"{name} is damaged ({error}); remove it, and start again.") from None


def encoded(record: Record) -> bytes:
    """Return a record as the content of its file."""
    return msgspec.json.format(msgspec.json.encode(record), indent=1) + b"\n"
