"""What a batch keeps beside its results: its jobs, its options, and the table of all records."""

from __future__ import annotations

import csv
import importlib.util
from collections import Counter
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import Any, Literal

import msgspec

from motes import ConfigError, FormatError
from motes.core import guarded, writing
from motes_fleet.cluster.jobs import Job
from motes_fleet.cluster.records import Record, records
from motes_fleet.cluster.store import Store

JOBS, OPTIONS = "jobs.jsonl", "batch.json"
TABLE = "jobs"
"""The name of the table of records, without its ending."""
COLUMNS: dict[str, type] = {
    "job": str, "do": str, "source": str, "label": str, "status": str, "attempts": int,
    "seconds": float, "frames": int, "host": str, "version": str, "checksum": str, "error": str,
}  # fmt: skip
"""Columns of that table; the checksum is SHA-256 of the source."""
TOGETHER = 1000
"""Rows that are written at a time."""


class Options(msgspec.Struct, frozen=True):
    """What `motes batch retry` has to know: the number of jobs, and the form of the results."""

    total: int
    form: Literal["csv", "parquet"]
    overlay: bool


def save(store: Store, jobs: Iterable[Job], options: Options) -> None:
    """Write the jobs and the options; the jobs pass through, and are not held."""
    with writing(JOBS), store.scratch() as folder:
        path = Path(folder) / JOBS
        with path.open("wb") as file:
            for job in jobs:
                file.write(msgspec.json.encode(job) + b"\n")
        store.write(JOBS, path)
    store.write(OPTIONS, msgspec.json.encode(options) + b"\n")


def load_options(store: Store, out: str) -> Options:
    """Return the options of a batch.

    Raises
    ------
    ConfigError
        If there is no batch.
    FormatError
        If they are damaged.
    """
    data = store.read([OPTIONS]).get(OPTIONS)
    if data is None:
        raise ConfigError(f"There is no batch in {out}; motes batch JOBS -o {out} begins one.")
    try:
        return msgspec.json.decode(data, type=Options)
    except msgspec.MsgspecError as error:
        raise FormatError(f"{out}/{OPTIONS} is damaged ({error}); begin the batch again.") from None


def load_jobs(store: Store) -> Iterator[Job]:
    """Yield the jobs of a batch, as they were saved."""
    decoder = msgspec.json.Decoder(Job)
    for line in store.lines(JOBS):
        yield decoder.decode(line)


def counts(store: Store) -> tuple[Counter[str], list[Record]]:
    """Return the number of jobs of each status, and the records of those that failed."""
    found, failed = Counter[str](), []
    for _, record in records(store, load_jobs(store)):
        found["waiting" if record is None else record.status] += 1
        if record is not None and record.status == "failed":
            failed.append(record)
    return found, failed


def write_table(store: Store) -> str:
    """Write the records of all jobs as a table, and return its name: Parquet with pyarrow, or CSV.

    It is made from the store, so it also has what earlier runs have done.
    """
    parquet = importlib.util.find_spec("pyarrow") is not None
    name = f"{TABLE}.parquet" if parquet else f"{TABLE}.csv"
    with writing(name), store.scratch() as folder:
        path = Path(folder) / name
        rows = (_row(job, record) for job, record in records(store, load_jobs(store)))
        (_write_parquet if parquet else _write_csv)(path, rows)
        store.write(name, path)
    return name


def _row(job: Job, record: Record | None) -> dict[str, Any]:
    row = {"job": job.name, "do": job.do, "source": job.source, "label": job.label}
    if record is None:
        return {**row, "status": "waiting"}
    known = {name: getattr(record, name) for name in COLUMNS if hasattr(record, name)}
    return {**row, **known, "checksum": record.inputs[0].sha256 if record.inputs else None}


def _write_parquet(path: Path, rows: Iterator[dict[str, Any]]) -> None:
    import pyarrow
    import pyarrow.parquet

    kinds = {str: pyarrow.string(), int: pyarrow.int64(), float: pyarrow.float64()}
    schema = pyarrow.schema([(name, kinds[kind]) for name, kind in COLUMNS.items()])
    with pyarrow.parquet.ParquetWriter(path, schema) as writer:
        some: list[dict[str, Any]] = []
        for row in rows:
            some.append(row)
            if len(some) == TOGETHER:
                writer.write_table(pyarrow.Table.from_pylist(some, schema))
                some.clear()
        writer.write_table(pyarrow.Table.from_pylist(some, schema))


def _write_csv(path: Path, rows: Iterator[dict[str, Any]]) -> None:
    with path.open("w", newline="", encoding="utf-8") as file:
        writer = csv.DictWriter(file, [*COLUMNS], lineterminator="\n")
        writer.writeheader()
        for row in rows:
            writer.writerow({
                key: guarded(value) if isinstance(value, str) else value
                for key, value in row.items()
            })  # fmt: skip
