"""The efforts on all sequences of a dataset, in worker processes."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from functools import partial
from typing import NamedTuple

import numpy as np

from motes.cluster import pool as pools
from motes.cluster.local import LocalPool
from motes.cluster.pool import Ended, Task
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
    of_each = partial(of_film, config=config, rule=rule, seed=seed)
    tasks = [Task(film.name, of_each, film, seconds=math.inf) for film in films]
    with LocalPool(workers) as pool:
        ended = (event for event in pools.run(pool, tasks) if isinstance(event, Ended))
        for done, event in enumerate(ended, 1):
            if event.error is None:
                efforts[event.task.name] = event.value
            else:
                problems.append(Problem(f"sequence {event.task.name}", event.error))
            ordered = {film.name: efforts[film.name] for film in films if film.name in efforts}
            yield Measured(ordered, problems, done / len(tasks))


def of_film(film: Film, config: TrackerConfig, rule: str, seed: int) -> dict[str, Effort]:
    """Return the effort of each method on a sequence."""
    present = np.flatnonzero(np.isfinite(film.boxes).all(axis=1))
    reader = Reader(film.source, start=int(present[0]), end=film.frames)
    work = Work(reader, reader.frames, config, seed)
    found = {name: annotate(work, film.boxes, method, rule) for name, method in METHODS.items()}
    return found | {EQUIDISTANT: annotate_equidistant(work, film.boxes)}
