"""Passes of trackers over sequences, in worker processes that may hang, crash and be stopped.

A job is one tracker on one sequence in one protocol: its film is decoded once, and every frame is
handed to all of its passes in turn. So memory stays flat however long the film is. Each pass gets a
copy of the frame's pixels, so that none finds them changed, or what another has computed.
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
from motes.core.worker_processes import blocked_signals, cause
from motes.evaluation.adapters.registry import TrackerSpec
from motes.evaluation.adapters.sot import explain
from motes.evaluation.datasets.mot import MotSequence
from motes.evaluation.datasets.sot import Problem, Sequence
from motes.evaluation.protocols.mot import MotPass
from motes.evaluation.protocols.perturbations import LONGEST, Viewed, perturbations, show
from motes.evaluation.protocols.sot import Start, TrackerPass, starts
from motes.video.sources import open_source

LONGEST_NAME = 120
"""Of a folder; longer names are cut, and told apart by a digest."""
TIME_LIMIT = 1800.0
"""Seconds for a job, unless somebody says otherwise."""
WAIT = 3600.0
"""Seconds; for very long ones no system can be told to wait."""


@dataclass(frozen=True, slots=True)
class Pass:
    """One tracker over one sequence, from one start, with one seed."""

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
    """Return a name for a folder, another one for every name."""
    quoted = quote(name, safe="+")
    if len(quoted) <= LONGEST_NAME:
        return quoted
    return f"{quoted[:LONGEST_NAME]}%{hashlib.sha256(name.encode()).hexdigest()[:16]}"


@dataclass(frozen=True, slots=True, eq=False)
class Job:
    """All passes of a tracker over a sequence in a protocol."""

    entry: TrackerSpec
    sequence: Sequence | MotSequence
    passes: tuple[Pass, ...]

    @property
    def name(self) -> str:
        """For people."""
        protocol = self.passes[0].start.protocol
        return f"{self.entry.name} on {self.sequence.name}, {protocol}"


def plan(
    entries: Iterable[TrackerSpec],
    sequences: Iterable[Sequence | MotSequence],
    protocols: Iterable[str],
    seeds: int,
    longest: int = LONGEST,
) -> tuple[list[Job], list[Problem]]:
    """Return all jobs, sequence by sequence, and which sequences cannot be opened.

    A stochastic tracker is run with the seeds 0 to `seeds` - 1, any other one with 0.
    In the protocol `robust`, each view is a job of its own, of at most `longest` frames.
    """
    entries, protocols = list(entries), list(protocols)
    jobs: list[Job] = []
    problems: list[Problem] = []
    for sequence in sequences:
        try:
            with open_source(sequence.source) as film:
                size = film.width, film.height
        except MotesError as error:
            problems.append(Problem(f"sequence {sequence.name}", str(error)))
            continue
        for protocol in protocols:
            seen: Iterable[tuple[Sequence | MotSequence, list[Start]]]
            if protocol == "robust" and isinstance(sequence, Sequence):
                seen = perturbations(sequence, *size, longest)
            else:
                seen = [(sequence, starts(protocol, sequence, *size))]
            for (view, begins), entry in itertools.product(seen, entries):
                passes = (
                    Pass(entry.name, sequence.name, start, seed)
                    for start in begins
                    for seed in range(seeds if entry.stochastic else 1)
                )
                jobs.append(Job(entry, view, tuple(passes)))
    return jobs, problems


def unfinished(jobs: Iterable[Job], out: Path) -> list[Job]:
    """Return jobs with those of their passes whose tracks are not there yet."""
    left = (
        replace(job, passes=tuple(item for item in job.passes if not item.path(out).exists()))
        for job in jobs
    )
    return [job for job in left if job.passes]


class Step(NamedTuple):
    """A job has begun, or is over.

    Attributes
    ----------
    job
        Which one.
    errors
        Why passes failed, in one line each; the others have written their tracks. None if it has
        just begun.
    """

    job: Job
    errors: dict[Pass, str] | None


def run(
    jobs: Iterable[Job], out: Path, workers: int, time_limit: float
) -> Generator[Step, None, None]:
    """Do jobs in worker processes, and tell how it goes.

    Workers end with the generator, and with this process, whatever ends it. Close the generator
    if it is not exhausted.

    Parameters
    ----------
    jobs
        What to do.
    out
        The folder of the evaluation.
    workers
        How many jobs are done at a time.
    time_limit
        Seconds for each job; one that takes longer is stopped, and all of its passes fail.

    Raises
    ------
    FormatError
        If a track cannot be written.
    """
    context, queue = multiprocessing.get_context("spawn"), deque(jobs)
    idle: list[_Worker] = []
    busy: list[_Worker] = []
    # Here are the temporary files of all workers, so that those of stopped ones vanish as well.
    with tempfile.TemporaryDirectory(prefix="motes-") as scratch:
        try:
            while queue or busy:
                while queue and len(busy) < workers:
                    busy.append(idle.pop() if idle else _Worker(context, out, scratch))
                    busy[-1].give(queue.popleft())
                    yield Step(busy[-1].job, None)
                moment = min(worker.deadline for worker in busy) - time.monotonic()
                handles = [handle for worker in busy for handle in worker.handles]
                wait(handles, min(max(moment, 0), WAIT))
                for worker in list(busy):
                    errors = worker.listen(time_limit)
                    if errors is not None:
                        busy.remove(worker)
                        if worker.alive:
                            idle.append(worker)
                        yield Step(worker.job, errors)
        finally:
            with blocked_signals():
                for worker in (*idle, *busy):
                    worker.end()


class _Worker:
    """A process that does one job after the other."""

    job: Job

    def __init__(self, context: SpawnContext, out: Path, scratch: str) -> None:
        self._pipe, theirs = context.Pipe()
        self._process = context.Process(target=_serve, args=(theirs, out, scratch))
        with (
            blocked_signals()
        ):  # and so is the process, from its first instruction on: Ctrl-C is for us
            self._process.start()
        theirs.close()
        self.alive = True
        self.deadline = math.inf

    @property
    def handles(self) -> tuple[Any, ...]:
        """What becomes ready when there is something to listen to."""
        return self._pipe, self._process.sentinel

    def give(self, job: Job) -> None:
        """Have a job done."""
        self.job, self.deadline = job, math.inf
        with contextlib.suppress(OSError):  # if it is dead, it will be found so
            self._pipe.send(job)

    def listen(self, time_limit: float) -> dict[Pass, str] | None:
        """Return the errors of the job that is over; None as long as it goes on."""
        running = self._process.is_alive()
        with contextlib.suppress(EOFError, OSError):
            while self._pipe.poll():
                said = self._pipe.recv()
                if isinstance(said, FormatError):
                    raise said
                if said is not None:
                    errors: dict[Pass, str] = said
                    return errors
                self.deadline = time.monotonic() + time_limit  # it has begun
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
        """End the process, and all that it started."""
        self.alive = False
        if self._process.pid is not None:
            with contextlib.suppress(ProcessLookupError):
                os.killpg(self._process.pid, signal.SIGKILL)
        self._process.kill()
        self._process.join()
        self._pipe.close()


# In a worker


def _serve(pipe: Connection, out: Path, scratch: str) -> None:
    """Do jobs as they come."""
    os.setpgid(0, 0)  # a group of its own, with all programs that trackers start
    os.dup2(2, 1)  # standard output is for results
    os.environ["TMPDIR"] = tempfile.tempdir = scratch
    parent = multiprocessing.parent_process()
    assert parent is not None
    threading.Thread(target=_end_with, args=(parent.sentinel, scratch), daemon=True).start()
    with contextlib.suppress(EOFError):
        while True:
            job = pipe.recv()
            pipe.send(None)
            try:
                pipe.send(_do(job, out))
            except FormatError as error:
                pipe.send(error)


def _end_with(sentinel: int, scratch: str) -> None:
    """End this group with the program, whatever ends it, and clean up in its place."""
    wait([sentinel])
    shutil.rmtree(scratch, ignore_errors=True)
    os.killpg(0, signal.SIGKILL)


def _do(job: Job, out: Path) -> dict[Pass, str]:
    """Do a job; return the errors of the passes that failed."""
    errors: dict[Pass, str] = {}
    running = {item: _running(job, item) for item in job.passes}
    try:
        for frame in _film(job.sequence):
            for item in list(running):
                try:
                    running[item].feed(Frame(frame.index, frame.time, frame.pixels.copy()))
                except BaseException as error:  # whatever a tracker does
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


def _running(job: Job, item: Pass) -> TrackerPass | MotPass:
    """Return a pass that has not begun yet."""
    begin = partial(job.entry.begin, item.seed)
    if isinstance(job.sequence, MotSequence):
        return MotPass(begin, job.sequence)
    return TrackerPass(begin, item.start, job.sequence.boxes)


def _film(sequence: Sequence | MotSequence) -> Iterator[Frame]:
    """Yield the frames of a sequence; raise a SourceError if they are not as many as the truth."""
    if isinstance(sequence, Viewed):
        yield from show(sequence)
        return
    count, rows = 0, sequence.frames
    with open_source(sequence.source) as film:
        for frame in film:
            count += 1
            if count > rows:
                raise SourceError(f"{film.name} has more frames than its truth, which has {rows}.")
            yield frame
        if count < rows:
            why = f" ({film.report.problems})" if film.report.problems else ""
            raise SourceError(f"{film.name} has {count} frames{why}, but its truth has {rows}.")
