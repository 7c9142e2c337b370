"""The one function that does a job, wherever its worker is."""

from __future__ import annotations

import socket
import time
from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple

from msgspec.structs import replace

from motes import __version__
from motes.cluster.inputs import changed, localized
from motes.cluster.jobs import Job
from motes.cluster.objects import StoreError
from motes.cluster.pool import TryAgain
from motes.cluster.records import Record, encoded, place_of, read_record, record_name
from motes.cluster.store import Store, open_store, same, sha256
from motes.core.errors import FormatError, MotesError, SourceError


class Made(NamedTuple):
    """What a job has made.

    Attributes
    ----------
    frames
        The number of frames that it used.
    note
        What was strange, in one line, or None.
    """

    frames: int
    note: str | None = None


class Order(NamedTuple):
    """A job with all that a worker needs to do it.

    Attributes
    ----------
    job, digest
        The job, and the digest of its record.
    out
        The address of the store.
    make
        Writes the results of a job, whose files are on this machine, into a folder: `rows.*`,
        `events.*` and `overlay.*`. It is a function at the top level of a module.
    form
        The ending of the rows: csv or parquet.
    overlay
        Whether an annotated video is made.
    """

    job: Job
    digest: str
    out: str
    make: Callable[[Job, Path, str, bool], Made]
    form: str
    overlay: bool


def work(order: Order) -> Record:
    """Do a job; return its record, which is in the store already if the job is done.

    Raises
    ------
    TryAgain
        If a server or the network fails.
    FormatError
        If the store cannot be written.
    """
    begun, store = time.perf_counter(), open_store(order.out)
    record = Record(
        name=order.job.name,
        status="failed",
        digest=order.digest,
        host=socket.gethostname(),
        version=__version__,
    )
    try:
        with store.scratch() as scratch:
            made = Path(scratch) / "made"
            made.mkdir()
            try:
                job, inputs = localized(order.job, Path(scratch) / "inputs")
                record = replace(record, inputs=inputs)
                result = order.make(job, made, order.form, order.overlay)
                if changed(inputs):
                    raise SourceError("An input has changed while it was read; start again.")
            except StoreError:
                raise
            except MotesError as error:
                seconds = round(time.perf_counter() - begun, 3)
                return replace(record, seconds=seconds, error=str(error))
            names = {place_of(order.job.name, path.name): path for path in sorted(made.iterdir())}
            files = {name: sha256(path) for name, path in names.items()}
            for name, path in names.items():
                _publish(store, name, path, files[name])
    except StoreError as error:
        raise TryAgain(str(error)) from None
    record = replace(
        record,
        status="done",
        frames=result.frames,
        files=files,
        error=result.note,
        seconds=round(time.perf_counter() - begun, 3),
    )
    return _commit(store, record)


def _publish(store: Store, name: str, path: Path, digest: str) -> None:
    """Give a result its name; what is there already without a record is of an earlier attempt."""
    if not store.create(name, path) and not same(store, name, digest):
        store.replace(name, path)


def _commit(store: Store, record: Record) -> Record:
    """Write the record, by which the job is done; return the one that is there."""
    name = record_name(record.name)
    if store.create(name, encoded(record)):
        return record
    other = read_record(store, record.name)
    if other is None or other.files != record.files:
        raise FormatError(f"{name} is of another result; start the batch again.")
    return other
