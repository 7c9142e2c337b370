"""The parts of `motes-lab bench`: what each measures, and its tables."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING, Literal, get_args

from motes.synthetic.clips import crowd, still
from motes_lab.datasets.sot import Problem
from motes_lab.datasets.sot import Sequence as TrueSequence
from motes_lab.experiment import Experiment, Result
from motes_lab.report.tables import Table
from motes_lab.speed import files, growth
from motes_lab.speed import measure as speed
from motes_lab.speed import plot as speed_plot
from motes_lab.speed import report as speed_report
from motes_lab.speed.growth import Growth
from motes_lab.speed.measure import LARGE, MAIN, REFERENCE, SIZE, Film, Job, Run
from motes_lab.speed.report import Ratio, named_size

if TYPE_CHECKING:
    from matplotlib.figure import Figure

Part = Literal["trackers", "sequences", "growth", "files"]
PARTS: tuple[Part, ...] = get_args(Part)
FRAMES = 31
"""Frames of each clip."""
SMALL, SMALL_TARGET = (480, 270), (30, 50)
"""Frame and target before they are enlarged."""
UPDATES = 5
"""Updates of a crowd, and of large frames, in each round: a thousand targets take seconds."""
LENGTH, LARGE_LENGTH = 400, 100
"""Frames of the files."""


class Measured:
    """Times that are measured, and the tables that are made of them.

    Parameters
    ----------
    rounds
        How often each job runs.
    stored
        Ratios to the peers of another run; None to compare with none.
    sequences
        Real sequences.
    networks
        Networks of OpenCV, with their files, that run on these too.
    plot
        Whether a plot is drawn.
    """

    def __init__(
        self,
        rounds: int,
        stored: Mapping[Ratio, float] | None,
        sequences: Sequence[TrueSequence],
        networks: Sequence[str],
        *,
        plot: bool,
    ) -> None:
        self._rounds, self._stored, self._plot = rounds, stored, plot
        self._sequences, self._networks = sequences, networks
        self._tables: dict[str, Table] = {}
        self._growths: dict[str, Growth] = {}
        self._updates: dict[Job, list[float]] = {}
        self._problems: dict[Problem, None] = {}

    def steps(self, parts: Iterable[Part]) -> Experiment:
        """Measure parts; yield the results so far after each round of each."""
        measure: dict[Part, Callable[[], Iterator[str]]] = {
            "trackers": self._trackers,
            "sequences": self._real,
            "growth": self._growth,
            "files": self._files,
        }
        for part in parts:
            for progress in measure[part]():
                draw = self._draw if self._plot else None
                yield Result({**self._tables}, draw, (*self._problems,), progress)

    def _draw(self) -> Figure:
        return speed_plot.figure(self._updates, [*self._growths.values()])

    def _trackers(self) -> Iterator[str]:
        films = {target: Film.of(still(SIZE, target, FRAMES)) for target in speed.TARGETS}
        jobs, missing = speed.trackers(films)
        for updates in speed.interleaved(jobs, self._rounds):
            self._updates = updates
            self._tables["trackers"] = table = speed_report.trackers_table(updates, missing)
            if self._stored is not None:
                self._tables["against"] = speed_report.against(table, self._stored)
            yield "trackers"

    def _real(self) -> Iterator[str]:
        names, missing = speed.available([*speed.RIVALS, *self._networks])
        names = [*speed.FOLLOWERS, *names]
        seconds: dict[tuple[str, str], list[float]] = {}
        for _, sequence in itertools.product(range(self._rounds), self._sequences):
            found, failed = speed.in_lockstep(names, sequence, FRAMES)
            self._problems.update(dict.fromkeys(failed))
            for name, times in found.items():
                seconds.setdefault((sequence.name, name), []).extend(times)
            self._tables["sequences"] = speed_report.sequences_table(seconds, missing)
            yield f"sequences, {sequence.name}"

    def _growth(self) -> Iterator[str]:
        film = Film.of(still(SIZE, MAIN, FRAMES))
        small = Film.of(still(SMALL, SMALL_TARGET, UPDATES + 1))
        many = Film.of(crowd(LARGE, MAIN), UPDATES + 1)
        size, large = named_size(SIZE), named_size(LARGE)
        divided = f"{growth.DIVIDED} targets of {REFERENCE}, {large}"
        for what, title, jobs, measured in (
            ("targets", f"{REFERENCE}, frames of {large}", growth.targets, many),
            ("particles", f"{REFERENCE}, frames of {size}", growth.particles, film),
            ("megapixels", "one target, the same scene enlarged", growth.megapixels, small),
            ("threads", divided, growth.threads, many),
            ("processes", divided, growth.processes, many),
        ):
            rounds = speed.interleaved(jobs(measured), self._rounds)
            for done, seconds in enumerate(rounds, start=1):
                self._growths[what] = found = Growth.over(what, title, seconds, done)
                self._tables[what] = found.table()
                yield what

    def _files(self) -> Iterator[str]:
        with TemporaryDirectory(prefix="motes-") as folder:
            runs: dict[tuple[str, str], Run] = {}
            for name, clip, targets, length in (
                ("one target", still(SIZE, MAIN, FRAMES), 1, LENGTH),
                ("ten targets", crowd(LARGE, MAIN), 10, LARGE_LENGTH),
            ):
                jobs = files.jobs(Path(folder), name, Film.of(clip), targets, length)
                title = f"{named_size(clip.size)}, {name}"
                runs |= {(title, what): run for what, run in jobs.items()}
            for seconds in speed.interleaved(runs, self._rounds):
                self._tables["files"] = speed_report.files_table(seconds)
                yield "files"
