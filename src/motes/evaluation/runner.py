"""Passes of trackers over sequences, in worker processes that may hang, crash and be stopped.

A job is one tracker on one sequence in one protocol. Its video is decoded once, and each frame is
given to all of its passes in turn, so the memory needed does not depend on the length of the video.
Each pass gets its own copy of the frame: it sees neither changed pixels nor values cached by
another pass.
"""

from __future__ import annotations

import contextlib
import hashlib
import itertools
import math
import multiprocessing
import os
import shutil
import signal
import tempfile
import threading
import time
from collections import deque
from collections.abc import Generator, Iterable, Iterator
from dataclasses import dataclass, replace
from functools import partial
from multiprocessing.connection import Connection, wait
from multiprocessing.context import SpawnContext
from pathlib import Path
from typing import Any, NamedTuple
from urllib.parse import quote

from motes.core.errors import FormatError, MotesError, SourceError
from motes.core.frame import Frame
from motes.core.import_callable import explain
from motes.core.worker_processes import blocked_signals, cause
from motes.evaluation.adapters.registry import TrackerSpec
from motes.evaluation.datasets.mot import MotSequence
from motes.evaluation.datasets.sot import Problem, Sequence
from motes.evaluation.protocols.mot import MotPass
from motes.evaluation.protocols.perturbations import (
    MAX_FRAMES,
    PerturbedSequence,
    perturbations,
    perturbed_frames,
)
from motes.evaluation.protocols.sot import Start, TrackerPass, starts
from motes.video.sources import open_source

LONGEST_NAME = 120
"""Longest name of a folder; longer names are cut and get a digest, so that they stay different."""
TIME_LIMIT = 1800.0
"""Seconds for a job, by default."""
LONGEST_WAIT = 3600.0
"""Seconds; operating systems limit how long a process can wait at once."""


@dataclass(frozen=True, slots=True)
class Pass:
    """One tracker on one sequence, with one start and one seed."""

    tracker: str
    sequence: str
    start: Start
    seed: int

    def path(self, out: Path) -> Path:
        """Return the file of its track in the folder of an evaluation."""
        parts = (self.start.protocol, self.start.label, str(self.seed))
        name = "-".join(part for part in parts if part)
        return out / "tracks" / slug(self.tracker) / slug(self.sequence) / f"{name}.csv"


def slug(name: str) -> str:
    """Return a folder name, a different one for each name."""
    quoted = quote(name, safe="+")
    if len(quoted) <= LONGEST_NAME:
        return quoted
    return f"{quoted[:LONGEST_NAME]}%{hashlib.sha256(name.encode()).hexdigest()[:16]}"


@dataclass(frozen=True, slots=True, eq=False)
class Job:
    """All passes of a tracker over a sequence in a protocol."""

    spec: TrackerSpec
    sequence: Sequence | MotSequence
    passes: tuple[Pass, ...]

    @property
    def name(self) -> str:
        """The name of the job in messages."""
        protocol = self.passes[0].start.protocol
        return f"{self.spec.name} on {self.sequence.name}, {protocol}"


def plan(
    specs: Iterable[TrackerSpec],
    sequences: Iterable[Sequence | MotSequence],
    protocols: Iterable[str],
    seeds: int,
    max_frames: int = MAX_FRAMES,
) -> tuple[list[Job], list[Problem]]:
    """Return all jobs, sequence by sequence, and the problems of sequences that cannot be opened.

    A stochastic tracker is run with the seeds 0 to `seeds` - 1, any other tracker with seed 0. In
    the protocol `robust`, each view is a separate job of at most `max_frames` frames.
    """
    specs, protocols = list(specs), list(protocols)
    jobs: list[Job] = []
    problems: list[Problem] = []
    for sequence in sequences:
        try:
            with open_source(sequence.source) as source:
                size = source.width, source.height
        except MotesError as error:
            problems.append(Problem(f"sequence {sequence.name}", str(error)))
            continue
        for protocol in protocols:
            views: Iterable[tuple[Sequence | MotSequence, list[Start]]]
            if protocol == "robust" and isinstance(sequence, Sequence):
                views = perturbations(sequence, *size, max_frames)
            else:
                views = [(sequence, starts(protocol, sequence, *size))]
            for (view, view_starts), spec in itertools.product(views, specs):
                passes = (
                    Pass(spec.name, sequence.name, start, seed)
                    for start in view_starts
                    for seed in range(seeds if spec.stochastic else 1)
                )
                jobs.append(Job(spec, view, tuple(passes)))
    return jobs, problems


def unfinished(jobs: Iterable[Job], out: Path) -> list[Job]:
    """Return the jobs with only those passes whose tracks do not exist yet."""
    left = (
        replace(job, passes=tuple(item for item in job.passes if not item.path(out).exists()))
        for job in jobs
    )
    return [job for job in left if job.passes]


class JobEvent(NamedTuple):
    """The start or the end of a job.

    Attributes
    ----------
    job
        The job.
    errors
        The passes that failed, each with the reason in one line; all others have written their
        tracks. None at the start of the job.
    """

    job: Job
    errors: dict[Pass, str] | None


def run(
    jobs: Iterable[Job], out: Path, workers: int, time_limit: float
) -> Generator[JobEvent, None, None]:
    """Run jobs in worker processes; yield the start and the end of each job.

    The workers end with the generator, and also with this process, however it ends. Close the
    generator if it is not exhausted.

    Parameters
    ----------
    jobs
        The jobs to run.
    out
        The folder of the evaluation.
    workers
        Number of jobs that run at the same time.
    time_limit
        Seconds for each job; a job that takes longer is stopped, and all of its passes fail.

    Raises
    ------
    FormatError
        If a track cannot be written.
    """
    context, queue = multiprocessing.get_context("spawn"), deque(jobs)
    idle: list[_Worker] = []
    busy: list[_Worker] = []
    # The temporary files of all workers are here, so that those of stopped ones are removed too.
    with tempfile.TemporaryDirectory(prefix="motes-") as scratch:
        try:
            while queue or busy:
                while queue and len(busy) < workers:
                    busy.append(idle.pop() if idle else _Worker(context, out, scratch))
                    busy[-1].assign(queue.popleft())
                    yield JobEvent(busy[-1].job, None)
                timeout = min(worker.deadline for worker in busy) - time.monotonic()
                handles = [handle for worker in busy for handle in worker.handles]
                wait(handles, min(max(timeout, 0), LONGEST_WAIT))
                for worker in list(busy):
                    errors = worker.poll(time_limit)
                    if errors is not None:
                        busy.remove(worker)
                        if worker.alive:
                            idle.append(worker)
                        yield JobEvent(worker.job, errors)
        finally:
            with blocked_signals():
                for worker in (*idle, *busy):
                    worker.end()


class _Worker:
    """A process that runs one job after another."""

    job: Job

    def __init__(self, context: SpawnContext, out: Path, scratch: str) -> None:
        self._pipe, worker_end = context.Pipe()
        self._process = context.Process(target=_serve, args=(worker_end, out, scratch))
        # The process inherits the blocked signals: Ctrl-C is handled by the main program alone.
        with blocked_signals():
            self._process.start()
        worker_end.close()
        self.alive = True
        self.deadline = math.inf

    @property
    def handles(self) -> tuple[Any, ...]:
        """Handles that become ready when `poll` has something to read."""
        return self._pipe, self._process.sentinel

    def assign(self, job: Job) -> None:
        """Give the worker a job."""
        self.job, self.deadline = job, math.inf
        with contextlib.suppress(OSError):  # `poll` will notice if the process is dead
            self._pipe.send(job)

    def poll(self, time_limit: float) -> dict[Pass, str] | None:
        """Return the errors of the job if it has ended; None while it runs."""
        running = self._process.is_alive()
        with contextlib.suppress(EOFError, OSError):
            while self._pipe.poll():
                message = self._pipe.recv()
                if isinstance(message, FormatError):
                    raise message
                if message is not None:
                    errors: dict[Pass, str] = message
                    return errors
                self.deadline = time.monotonic() + time_limit  # None: the job has started
        if running and time.monotonic() < self.deadline:
            return None
        self.end()
        error = (
            f"It took longer than the {time_limit:g} s that each job has, and was stopped."
            if running
            else f"Its process ended with {cause(self._process.exitcode)}."
        )
        return dict.fromkeys(self.job.passes, error)

    def end(self) -> None:
        """End the process and all processes that it started."""
        self.alive = False
        if self._process.pid is not None:
            with contextlib.suppress(ProcessLookupError):
                os.killpg(self._process.pid, signal.SIGKILL)
        self._process.kill()
        self._process.join()
        self._pipe.close()


# The functions below run in a worker.


def _serve(pipe: Connection, out: Path, scratch: str) -> None:
    """Run jobs as they arrive."""
    os.setpgid(0, 0)  # a new process group, with all programs that trackers start
    os.dup2(2, 1)  # standard output is for results
    os.environ["TMPDIR"] = tempfile.tempdir = scratch
    parent = multiprocessing.parent_process()
    assert parent is not None
    threading.Thread(target=_end_with_parent, args=(parent.sentinel, scratch), daemon=True).start()
    with contextlib.suppress(EOFError):
        while True:
            job = pipe.recv()
            pipe.send(None)
            try:
                pipe.send(_run_job(job, out))
            except FormatError as error:
                pipe.send(error)


def _end_with_parent(sentinel: int, scratch: str) -> None:
    """End this process group when the main program ends, and remove its files."""
    wait([sentinel])
    shutil.rmtree(scratch, ignore_errors=True)
    os.killpg(0, signal.SIGKILL)


def _run_job(job: Job, out: Path) -> dict[Pass, str]:
    """Run a job; return the errors of the passes that failed."""
    errors: dict[Pass, str] = {}
    running = {item: _new_pass(job, item) for item in job.passes}
    try:
        for frame in _frames(job.sequence):
            for item in list(running):
                try:
                    running[item].feed(Frame(frame.index, frame.time, frame.pixels.copy()))
                except BaseException as error:  # a tracker may raise anything
                    errors[item] = f"At frame {frame.index}: {explain(error)}"
                    running.pop(item).close()
            if not running:
                break
        for item, ended in running.items():
            ended.save(item.path(out))
    except FormatError:
        raise
    except Exception as error:
        errors |= dict.fromkeys(running, explain(error))
    finally:
        for ended in running.values():
            ended.close()
    return errors


def _new_pass(job: Job, item: Pass) -> TrackerPass | MotPass:
    """Return a pass that has not started yet."""
    make_adapter = partial(job.spec.begin, item.seed)
    if isinstance(job.sequence, MotSequence):
        return MotPass(make_adapter, job.sequence)
    return TrackerPass(make_adapter, item.start, job.sequence.boxes)


def _frames(sequence: Sequence | MotSequence) -> Iterator[Frame]:
    """Yield the frames of a sequence; raise a SourceError if the truth has more or fewer rows."""
    if isinstance(sequence, PerturbedSequence):
        yield from perturbed_frames(sequence)
        return
    count, rows = 0, sequence.frames
    with open_source(sequence.source) as source:
        for frame in source:
            count += 1
            if count > rows:
                raise SourceError(
                    f"{source.name} has more frames than its truth, which has {rows}."
                )
            yield frame
        if count < rows:
            why = f" ({source.report.problems})" if source.report.problems else ""
            raise SourceError(f"{source.name} has {count} frames{why}, but its truth has {rows}.")
