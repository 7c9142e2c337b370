"""Passes of trackers over sequences, in workers that may hang, crash and be stopped.

A job is one tracker on one sequence in one protocol. Its video is decoded once, and each frame is
given to all of its passes in turn, so the memory needed does not depend on the length of the video.
In an evaluation each pass gets its own copy of the frame: it sees neither changed pixels nor values
cached by another pass. In an experiment, which measures no time, several trackers may be one job,
and all share a frame and what was computed of it.
"""

from __future__ import annotations

import tempfile
from collections.abc import Generator, Iterable, Iterator
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import NamedTuple, Self

from motes import Frame, MotesError, SourceError, open_source
from motes.core import explain, write_whole, writing
from motes_fleet.cluster import pool as pools
from motes_fleet.cluster.records import slug
from motes_lab.adapters.registry import TrackerSpec
from motes_lab.datasets.mot import MotSequence
from motes_lab.datasets.shortened import ShortSequence, frames_of
from motes_lab.datasets.sot import Problem, Sequence
from motes_lab.protocols.mot import MotPass
from motes_lab.protocols.sot import Start, TrackerPass, starts


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


@dataclass(frozen=True, slots=True, eq=False)
class Job:
    """All passes of trackers over a sequence in a protocol."""

    specs: tuple[TrackerSpec, ...]
    sequence: Sequence | MotSequence
    passes: tuple[Pass, ...]

    @classmethod
    def of(
        cls,
        specs: Iterable[TrackerSpec],
        sequence: Sequence | MotSequence,
        beginnings: Iterable[Start],
        seeds: int,
    ) -> Self:
        """Return the job of all starts; a tracker that is stochastic runs with each seed."""
        specs, beginnings = tuple(specs), list(beginnings)
        passes = (
            Pass(spec.name, sequence.name, start, seed)
            for spec in specs
            for start in beginnings
            for seed in range(seeds if spec.stochastic else 1)
        )
        return cls(specs, sequence, tuple(passes))

    @property
    def name(self) -> str:
        """The name of the job in messages."""
        trackers = ", ".join(spec.name for spec in self.specs)
        return f"{trackers} on {self.sequence.name}, {self.passes[0].start.protocol}"


def plan(
    specs: Iterable[TrackerSpec],
    sequences: Iterable[Sequence | MotSequence],
    protocols: Iterable[str],
    seeds: int,
) -> tuple[list[Job], list[Problem]]:
    """Return all jobs, sequence by sequence, and the problems of sequences that cannot be opened.

    A stochastic tracker is run with the seeds 0 to `seeds` - 1, any other tracker with seed 0.
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
            beginnings = starts(protocol, sequence, *size)
            jobs += (Job.of([spec], sequence, beginnings, seeds) for spec in specs)
    return jobs, problems


def unfinished(jobs: Iterable[Job], out: Path) -> list[Job]:
    """Return the jobs with only those passes whose tracks do not exist yet."""
    left = (
        replace(job, passes=tuple(item for item in job.passes if not item.path(out).exists()))
        for job in jobs
    )
    return [job for job in left if job.passes]


class JobEvent(NamedTuple):
    """The start or the end of a job."""

    job: Job
    """The job."""
    errors: dict[Pass, str] | None
    """The passes that failed, each with the reason in one line; all others have written their
    tracks. None at the start of the job."""


def run(
    pool: pools.Pool, jobs: Iterable[Job], out: Path, time_limit: float, attempts: int = 1
) -> Generator[JobEvent, None, None]:
    """Run jobs; yield the start and the end of each job.

    Parameters
    ----------
    pool
        The workers; the caller closes it.
    jobs
        The jobs to run.
    out
        The folder of the evaluation.
    time_limit
        Seconds for each job; a job that takes longer is stopped, and all of its passes fail.
    attempts
        How often a job whose worker dies is tried.

    Raises
    ------
    FormatError
        If a track cannot be written.
    """
    tasks = (pools.Task(job.name, run_job, job, seconds=time_limit) for job in jobs)
    for event in pools.run(pool, tasks, attempts):
        job: Job = event.task.argument
        if isinstance(event, pools.Started):
            yield JobEvent(job, None)
        elif isinstance(event, pools.Again):
            continue
        elif event.error is not None:
            yield JobEvent(job, dict.fromkeys(job.passes, event.error))
        else:
            errors, files = event.value
            for name, data in files:
                path = out / name
                with writing(path):
                    path.parent.mkdir(parents=True, exist_ok=True)
                    write_whole(path, data)
            yield JobEvent(job, errors)


# The functions below run in a worker.


def run_job(job: Job) -> tuple[dict[Pass, str], list[tuple[str, bytes]]]:
    """Run a job of an evaluation.

    Returns
    -------
    The errors of the passes that failed; and the files of all others, by their names in the folder
    of the evaluation. The file that makes a pass count as done comes after its others.
    """
    ended, errors = feed(job, shared=False)
    files: list[tuple[str, bytes]] = []
    try:
        with tempfile.TemporaryDirectory() as folder:
            for item, done in ended.items():
                path = item.path(Path(folder))
                done.save(path)
                for each in (path.with_suffix(".txt"), path):
                    if each.exists():
                        files.append((str(each.relative_to(folder)), each.read_bytes()))
    except Exception as error:
        errors |= dict.fromkeys(ended, explain(error))
    return errors, files


def feed(job: Job, *, shared: bool) -> tuple[dict[Pass, TrackerPass | MotPass], dict[Pass, str]]:
    """Run the passes of a job; return those that reached the end, and the errors of the others.

    Parameters
    ----------
    job
        The job.
    shared
        Whether all passes get the same frame; else each has its own copy.
    """
    errors: dict[Pass, str] = {}
    running = {item: _new_pass(job, item) for item in job.passes}
    try:
        for frame in _frames(job.sequence):
            if shared:
                frame.pixels.setflags(write=False)
            for item in list(running):
                own = frame if shared else Frame(frame.index, frame.time, frame.pixels.copy())
                try:
                    running[item].feed(own)
                except BaseException as error:  # a tracker may raise anything
                    errors[item] = f"At frame {frame.index}: {explain(error)}"
                    del running[item]
            if not running:
                break
    except Exception as error:
        return {}, errors | dict.fromkeys(running, explain(error))
    return running, errors


def _new_pass(job: Job, item: Pass) -> TrackerPass | MotPass:
    """Return a pass that has not started yet."""
    (spec,) = (each for each in job.specs if each.name == item.tracker)
    make_adapter = partial(spec.begin, item.seed)
    if isinstance(job.sequence, MotSequence):
        return MotPass(make_adapter, job.sequence)
    return TrackerPass(make_adapter, item.start)


def _frames(sequence: Sequence | MotSequence) -> Iterator[Frame]:
    """Yield the frames of a sequence; raise a SourceError if the truth has more or fewer rows."""
    if isinstance(sequence, ShortSequence):
        yield from frames_of(sequence)
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
