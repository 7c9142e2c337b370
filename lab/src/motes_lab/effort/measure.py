"""The efforts on all sequences of a dataset, in worker processes."""

from __future__ import annotations

import multiprocessing
from collections.abc import Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from typing import NamedTuple

import numpy as np

from motes.core.errors import MotesError
from motes.core.worker_processes import blocked_signals
from motes.sot.presets import TrackerConfig
from motes.video.film import Film as Reader
from motes_lab.datasets.sot import Problem
from motes_lab.datasets.sot import Sequence as Film
from motes_lab.effort.annotator import Effort, annotate, annotate_equidistant
from motes_lab.effort.methods import METHODS
from motes_lab.effort.methods import Film as Work

EQUIDISTANT = "interpolation, equidistant"
NAMES = (*METHODS, EQUIDISTANT)


class Measured(NamedTuple):
    """The efforts so far.

    Attributes
    ----------
    efforts
        By sequence, then by method.
    problems
        Sequences that failed.
    share
        Share of the sequences that are done.
    """

    efforts: dict[str, dict[str, Effort]]
    problems: list[Problem]
    share: float


def measured(
    films: Sequence[Film], config: TrackerConfig, rule: str, seed: int, workers: int
) -> Iterator[Measured]:
    """Measure sequence by sequence; yield the results after each one."""
    efforts: dict[str, dict[str, Effort]] = {}
    problems: list[Problem] = []
    context = multiprocessing.get_context("spawn")
    with blocked_signals():
        pool = ProcessPoolExecutor(workers, mp_context=context)
        jobs = {pool.submit(of_film, film, config, rule, seed): film.name for film in films}
    try:
        for done, job in enumerate(as_completed(jobs), 1):
            try:
                efforts[jobs[job]] = job.result()
            except MotesError as error:
                problems.append(Problem(f"sequence {jobs[job]}", str(error)))
            ordered = {film.name: efforts[film.name] for film in films if film.name in efforts}
            yield Measured(ordered, problems, done / len(jobs))
    finally:
        for process in list((pool._processes or {}).values()):
            process.terminate()  # after an interrupt, results of running jobs are not waited for
        pool.shutdown(cancel_futures=True)


def of_film(film: Film, config: TrackerConfig, rule: str, seed: int) -> dict[str, Effort]:
    """Return the effort of each method on a sequence."""
    present = np.flatnonzero(np.isfinite(film.boxes).all(axis=1))
    reader = Reader(film.source, start=int(present[0]), end=film.frames)
    work = Work(reader, reader.frames, config, seed)
    found = {name: annotate(work, film.boxes, method, rule) for name, method in METHODS.items()}
    return found | {EQUIDISTANT: annotate_equidistant(work, film.boxes)}
