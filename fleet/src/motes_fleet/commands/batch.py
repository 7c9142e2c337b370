"""`motes batch`: many films, on this machine or on a cluster."""

from __future__ import annotations

import contextlib
import functools
import io
import os
from collections.abc import Callable
from dataclasses import asdict
from typing import Annotated, Literal

from cyclopts import App, Group, Parameter

from motes import ConfigError, Regions, read_keyframes
from motes.cli import DONE, PARTIAL, FileName, OwnCode, Whole, call, log, options
from motes.core import counted, interrupts, optional
from motes.mot import check_code
from motes.sot import Network
from motes_fleet.cluster import driver, machine, pool as pools
from motes_fleet.cluster.jobs import Job
from motes_fleet.cluster.open_pool import open_pool
from motes_fleet.cluster.state import (
    Options,
    counts,
    load_jobs,
    load_options,
    save,
    write_table,
)
from motes_fleet.cluster.store import Store, open_store
from motes_fleet.cluster.table import JobTable
from motes_fleet.cluster.work import Plan
from motes_fleet.commands.batch_job import make, tracker_options
from motes_fleet.commands.batch_progress import BatchProgress
from motes_fleet.commands.workers import RUN, Cluster, Workers, check_run

app = App(name="batch", help_format="plaintext")
OUTPUT = Group("Output", sort_key=3)
CONFIGURATION = Group("Configuration", sort_key=4)
FLAG = Parameter(negative=(), show_default=False)


@options(RUN)
class WorkOptions:
    """The workers."""

    workers: Workers = None
    cluster: Cluster = None
    attempts: Whole = pools.ATTEMPTS
    """How often a job is tried if its worker dies, for example from lack of memory."""
    time_limit: float = pools.TIME_LIMIT
    """Seconds for a job."""
    own_code: OwnCode = False

    def check(self) -> None:
        """Check the numbers; raise a ConfigError for one that makes no sense."""
        check_run(self.workers, self.time_limit, attempts=self.attempts)


@options(CONFIGURATION)
class JobOptions:
    """Values of columns that a row leaves empty, or a pattern does not have."""

    do: Literal["track", "watch", "refine"] | None = None
    """What to do with the films."""
    init: Annotated[str | None, Parameter(allow_leading_hyphen=True)] = None
    """The target in the first frame."""
    detect: Literal["face"] | None = None
    """Wait for a face and track it."""
    keyframes: FileName | None = None
    """File of keyframes; each row begins with the name of its film."""
    detector: FileName | None = None
    """Detector of motes watch."""
    places: FileName | None = None
    """TOML file of lines and zones."""
    preset: str | None = None
    """Preset of the tracker."""
    config: FileName | None = None
    """TOML file whose values replace those of the preset."""
    seed: Whole | None = None
    """Seed of the random numbers."""
    network: FileName | None = None
    """Trained network that joins the tracker: nanotrack, or A.onnx,B.onnx."""

    def columns(self) -> dict[str, object]:
        """Return the values that are given, by their columns."""
        return {name: value for name, value in asdict(self).items() if value is not None}


@app.default
def batch(
    jobs: FileName,
    /,
    *,
    output: Annotated[FileName, Parameter(name=["--output", "-o"], group=OUTPUT)],
    rows: Annotated[Literal["csv", "parquet"], Parameter(group=OUTPUT)] = "csv",
    overlay: Annotated[bool, FLAG, Parameter(group=OUTPUT)] = False,
    columns: JobOptions = JobOptions(),
    work: WorkOptions = WorkOptions(),
) -> int:
    """Track in many films: each row of a table is a job.

    Results appear once and whole. A batch that was interrupted, or whose machine died, goes on when
    the same command is given again: what is done is not computed again, unless its inputs have
    changed. motes batch status OUT counts the jobs; motes batch retry OUT tries failed ones again.

    Parameters
    ----------
    jobs
        A table .csv, .jsonl, .parquet or .toml with the columns source, name, do, init,
        detect, keyframes, rows, detector, places, preset, config, seed, network, start, end,
        stride, fps and label (docs/batch.md); or a pattern of films, such as 'films/*.mp4'.
    output
        Folder of the results, or an address such as s3://BUCKET/PREFIX. Give the same one again to
        continue a batch.
    rows
        Form of the rows: CSV files, or a dataset of Parquet.
    overlay
        Make an annotated video of each film.
    """
    work.check()
    if rows == "parquet":
        optional("pyarrow", "Parquet needs pyarrow", "motes[parquet]")
    table = JobTable(jobs, columns.columns())
    check = functools.partial(_check_config, own_code=work.own_code)
    count, bad, problems = table.problems(check)
    for problem in problems:
        log(problem)
    if bad:
        raise ConfigError(f"{counted(bad, 'row')} of {jobs} cannot be used; nothing was started.")
    if not count:
        raise ConfigError(f"{jobs} has no job; add a row for each film.")
    store = open_store(output)
    with store.used_alone():
        options = Options(count, rows, overlay)
        save(store, table.jobs(), options)
        return _run(store, output, options, work, again=False)


@app.command
def status(out: str, /) -> int:
    """Count the jobs of a batch, and list those that failed.

    Parameters
    ----------
    out
        The folder or the address of the batch.
    """
    store = open_store(out)
    options = load_options(store, out)
    found, failed = counts(store)
    for record in failed:
        log(f"[{record.name}] failed after {counted(record.attempts, 'attempt')}: {record.error}")
    print(
        f"{counted(options.total, 'job')}: {found['done']} done, {found['failed']} failed, "
        f"{found['waiting']} waiting"
    )
    return PARTIAL if failed else DONE


@app.command
def retry(
    out: str,
    /,
    *,
    failed: Annotated[bool, FLAG] = False,
    work: WorkOptions = WorkOptions(),
) -> int:
    """Try the failed jobs of a batch again, and do those that are left.

    Parameters
    ----------
    out
        The folder or the address of the batch.
    failed
        Try those that failed too; without it, only those left.
    """
    work.check()
    store = open_store(out)
    options = load_options(store, out)
    with store.used_alone():
        return _run(store, out, options, work, again=failed)


def _check_config(job: Job, *, own_code: bool) -> None:
    """Check all that a job names but its films and rows; raise a MotesError."""
    check_code(job.detector, own_code)
    words = ["watch" if job.do == "watch" else "track", *tracker_options(job)]
    _check(*words, *([f"--detector={job.detector}"] if job.detector else ()))
    if job.network and not any("://" in path for path in job.network):
        _check_network(job.network)
    for read, path in ((Regions.load, job.places), (read_keyframes, job.keyframes)):
        if path and "://" not in path:
            _check_file(read, path)


@functools.cache
def _check(*words: str) -> None:
    with contextlib.redirect_stdout(io.StringIO()):
        call([*words, "--dump-config"])


@functools.cache
def _check_network(files: tuple[str, ...]) -> None:
    Network(files=files).open()


@functools.cache
def _check_file(read: Callable[[str], object], path: str) -> None:
    read(path)


def _run(store: Store, out: str, options: Options, work: WorkOptions, *, again: bool) -> int:
    """Do the jobs of a batch, and print a summary."""
    plan = Plan(
        out=out if "://" in out else os.path.abspath(out),
        make=make,
        form=options.form,
        overlay=options.overlay,
        attempts=work.attempts,
        time_limit=work.time_limit,
        again=again,
    )
    for job in load_jobs(store):  # also those of a folder that somebody else has made
        check_code(job.detector, work.own_code)
    workers = work.workers or machine.cores()
    threads = max(machine.cores() // workers, 1)
    interrupted: KeyboardInterrupt | None = None
    with BatchProgress(options.total) as progress:
        try:
            with open_pool(work.cluster, workers, threads) as pool:
                for event in driver.batch(pool, store, load_jobs(store), plan, progress.keep):
                    interrupts.check()
                    progress.note(event)
                    pool.show(progress.numbers())
        except KeyboardInterrupt as interrupt:
            interrupted = interrupt
    if interrupted is None:
        progress.written = write_table(store)
    log(f"{interrupts.word(interrupted)}{progress.summary(out)}.")
    if interrupted is not None:
        return interrupts.code(interrupted)
    return PARTIAL if progress.failed else DONE
