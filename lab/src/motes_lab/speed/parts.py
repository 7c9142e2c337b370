"""The parts of `motes-lab bench`: what each measures, and its tables."""

from __future__ import annotations

import itertools
from collections.abc import Collection, Mapping, Sequence
from typing import Literal, get_args

from motes.synthetic import still
from motes_lab.datasets.sot import Problem, Sequence as TrueSequence
from motes_lab.experiment import Experiment, Result
from motes_lab.report.tables import Table
from motes_lab.speed import measure as speed, report as speed_report
from motes_lab.speed.measure import SIZE, Film
from motes_lab.speed.report import Ratio

Part = Literal["trackers", "sequences"]
PARTS: tuple[Part, ...] = get_args(Part)
FRAMES = 31
"""Frames of each clip."""


def measured(
    parts: Collection[Part],
    rounds: int,
    stored: Mapping[Ratio, float] | None,
    sequences: Sequence[TrueSequence],
    networks: Sequence[str],
) -> Experiment:
    """Measure parts; yield the tables so far after each round of each.

    Parameters
    ----------
    parts
        What is measured.
    rounds
        How often each job runs.
    stored
        Ratios to the peers of another run; None to compare with none.
    sequences
        Real sequences.
    networks
        Networks of OpenCV, with their files, that run on these too.
    """
    tables: dict[str, Table] = {}
    if "trackers" in parts:
        films = {target: Film.of(still(SIZE, target, FRAMES)) for target in speed.TARGETS}
        jobs, missing = speed.trackers(films)
        for updates in speed.interleaved(jobs, rounds):
            tables["trackers"] = table = speed_report.trackers_table(updates, missing)
            if stored is not None:
                tables["against"] = speed_report.against(table, stored)
            yield Result({**tables}, progress="trackers")
    if "sequences" in parts:
        names, missing = speed.available([*speed.RIVALS, *networks])
        names = [*speed.FOLLOWERS, *names]
        seconds: dict[tuple[str, str], list[float]] = {}
        problems: dict[Problem, None] = {}
        for _, sequence in itertools.product(range(rounds), sequences):
            found, failed = speed.in_lockstep(names, sequence, FRAMES)
            problems.update(dict.fromkeys(failed))
            for name, times in found.items():
                seconds.setdefault((sequence.name, name), []).extend(times)
            tables["sequences"] = speed_report.sequences_table(seconds, missing)
            yield Result({**tables}, None, (*problems,), f"sequences, {sequence.name}")
