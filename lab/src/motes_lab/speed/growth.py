"""Growth of an update's time with particles, targets, pixels, threads and processes."""

from __future__ import annotations

import contextlib
import copy
import statistics
import time
from collections.abc import Iterator, Mapping, Sequence
from functools import partial
from multiprocessing.connection import Connection
from typing import NamedTuple, Self

import numpy as np
from msgspec.structs import replace

from motes.core.errors import MotesError
from motes.core.frame import Frame
from motes.core.geometry import Ellipse
from motes.core.worker_processes import cause
from motes.core.worker_processes import started as process_of
from motes.sot.batch import Trackers
from motes.sot.presets import preset
from motes.sot.tracker import Tracker
from motes_lab.report.tables import Cell, Row, Table, number
from motes_lab.speed.measure import FOLLOWERS, REFERENCE, Film, Run, ours, started, timed
from motes_lab.speed.measure import quick_start_config as quick_start

COUNTS, THREADS = (1, 10, 100, 1000), (1, 2)
"""Numbers of targets, and the numbers of threads in which they are measured."""
PARTICLES = (50, 100, 500, 1000, 5000)
FACTORS = (1, 2, 4, 8)
"""How many times as wide and as high a scene becomes."""
WORKERS, DIVIDED = (1, 2, 4), 100
"""Numbers of threads and of processes, and of the targets that are divided among them."""
PASSES = 3
"""How often processes follow the film in one run."""

Count = tuple[str, float]
"""A line of a plot, and a number of targets, particles, megapixels, threads or processes."""


SHARED_WORK = ("threads", "processes")
"""What becomes more where more workers share the same work: times shrink in proportion."""


class Power(NamedTuple):
    """The exponent p of the best fit n^p: the slope in a plot of both logarithms.

    Attributes
    ----------
    value
        The median over all rounds.
    low, high
        The lowest and the highest of a round.
    """

    value: float
    low: float
    high: float

    def __str__(self) -> str:
        return f"{self.value:.2f} ({self.low:.2f} to {self.high:.2f})"


class Growth(NamedTuple):
    """The growth of an update's time with a number.

    Attributes
    ----------
    what
        What becomes more: targets, particles, megapixels, threads or processes.
    title
        The tracker and the size of its frames.
    medians
        Median seconds of an update, by line of the plot and number.
    powers
        The fitted exponents, by line.
    """

    what: str
    title: str
    medians: dict[str, dict[float, float]]
    powers: dict[str, Power]

    @classmethod
    def over(
        cls, what: str, title: str, seconds: Mapping[Count, list[float]], rounds: int = 1
    ) -> Self:
        """Return the growth of the median times; a round has as many times as another."""
        medians: dict[str, dict[float, float]] = {}
        single: dict[str, list[dict[float, float]]] = {}
        for (line, n), times in seconds.items():
            medians.setdefault(line, {})[n] = statistics.median(times)
            each = single.setdefault(line, [{} for _ in range(rounds)])
            for found, part in zip(each, np.array_split(times, rounds), strict=True):
                found[n] = statistics.median(part.tolist())
        powers = {line: _power(each) for line, each in single.items()}
        return cls(what, title, medians, powers)

    @property
    def proportional(self) -> int:
        """The exponent of growth in proportion."""
        return -1 if self.what in SHARED_WORK else 1

    def table(self) -> Table:
        """Return a table with a column for each line, and the first line's time in proportion."""
        first, *_ = lines = [*self.medians.values()]
        one = next(iter(first.values()))
        rows: list[Row] = [
            (
                Cell(f"{n:g}"),
                *(number(1e3 * line[n]) for line in lines),
                number(1e6 * first[n] / n, 1) if self.proportional > 0 else number(one / first[n]),
            )
            for n in first
        ]
        foot = (Cell("power"), *(Cell(str(self.powers[line])) for line in self.medians), Cell(""))
        last = "µs for each" if self.proportional > 0 else "times as fast"
        head = (self.what, *(f"{line}, ms" for line in self.medians), last)
        note = (
            f"Times grow with that power of the number: {self.proportional} is in proportion. It "
            f"is the median of all rounds; in brackets are the least and the greatest."
        )
        return Table(f"{self.title}, by number of {self.what}", head, rows, (foot,), note)


def _power(rounds: Sequence[Mapping[float, float]]) -> Power:
    """Return the exponent of times by number, each of the median of a round."""
    fitted = []
    for medians in rounds:
        logs = np.log([*medians.items()])
        fitted.append(float(np.polyfit(logs[:, 0], logs[:, 1], 1)[0]))
    return Power(statistics.median(fitted), min(fitted), max(fitted))


def particles(film: Film) -> dict[Count, Run]:
    """Return runs of the reference tracker with growing numbers of particles."""
    config = preset(REFERENCE)
    return {(REFERENCE, n): ours(replace(config, particles=n), film) for n in PARTICLES}


def targets(film: Film) -> dict[Count, Run]:
    """Return runs of growing numbers of reference trackers on one film, by number of threads.

    If there are more trackers than targets in the film, several follow the same target.
    """
    jobs: dict[Count, Run] = {}
    for n in COUNTS:
        each = _started(film.frames[0], _regions(film, n))
        for threads in THREADS:
            line = f"{threads} thread{'s' * (threads > 1)}"
            jobs[line, n] = partial(_many, threads, each, film.frames[1:])
    return jobs


def megapixels(film: Film) -> dict[Count, Run]:
    """Return runs of single trackers on a film that is enlarged, with its target."""
    jobs: dict[Count, Run] = {}
    for factor in FACTORS:
        first = _enlarged(film.frames[0], factor)
        x, y, a, b, theta = film.regions[0]
        x, y = (factor * (value + 0.5) - 0.5 for value in (x, y))
        region = Ellipse(x, y, factor * a, factor * b, theta)
        for name in FOLLOWERS:
            tracker = started(preset(name), first, region)
            jobs[name, first.width * first.height / 1e6] = partial(
                _enlarging, tracker, film.frames[1:], factor
            )
    return jobs


def _enlarging(tracker: Tracker, frames: Sequence[Frame], factor: int) -> list[float]:
    enlarged = (_enlarged(frame, factor) for frame in frames)
    return timed(copy.copy(tracker).update, enlarged)


def _enlarged(frame: Frame, factor: int) -> Frame:
    pixels = frame.pixels.repeat(factor, axis=0).repeat(factor, axis=1)
    return Frame(frame.index, frame.time, pixels)


def threads(film: Film) -> dict[Count, Run]:
    """Return runs of the same targets, divided among growing numbers of threads."""
    each = _started(film.frames[0], _regions(film, DIVIDED))
    return {("threads", n): partial(_many, n, each, film.frames[1:]) for n in WORKERS}


def processes(film: Film) -> dict[Count, Run]:
    """Return runs of the same targets, divided among growing numbers of processes.

    Processes are started in each run; they have their frames and trackers before time is taken.
    """
    regions = _regions(film, DIVIDED)
    return {("processes", n): partial(_divided, n, film.frames, regions) for n in WORKERS}


def _regions(film: Film, n: int) -> list[Ellipse]:
    return [film.regions[i % len(film.regions)] for i in range(n)]


def _started(frame: Frame, regions: Sequence[Ellipse]) -> list[Tracker]:
    ready = Trackers(quick_start())
    ready.init(frame, regions)
    return ready.each


def _many(threads: int, each: Sequence[Tracker], frames: Sequence[Frame]) -> list[float]:
    """Return the seconds of each update of copies of started trackers."""
    with Trackers(quick_start(), threads=threads) as trackers:
        trackers.each = [copy.copy(tracker) for tracker in each]
        return timed(trackers.update, frames)


def _divided(n: int, frames: Sequence[Frame], regions: Sequence[Ellipse]) -> list[float]:
    """Return the seconds of an update of all regions, by n processes, in each pass."""
    with contextlib.ExitStack() as stack:
        workers = [stack.enter_context(_worker(frames, regions[i::n])) for i in range(n)]
        seconds = []
        for _ in range(PASSES):
            for pipe in workers:
                pipe.recv()
            start = time.perf_counter()
            for pipe in workers:
                pipe.send(None)
            for pipe in workers:
                pipe.recv()
            seconds.append((time.perf_counter() - start) / (len(frames) - 1))
        return seconds


@contextlib.contextmanager
def _worker(frames: Sequence[Frame], regions: Sequence[Ellipse]) -> Iterator[Connection]:
    """Start a process that sends None before and after each pass, and receives one between."""
    process, pipe = process_of(_serve, frames, regions)
    try:
        yield pipe
    except (EOFError, OSError):
        process.join()
        raise MotesError(f"A measured process ended with {cause(process.exitcode)}.") from None
    finally:
        process.kill()
        process.join()


def _serve(pipe: Connection, frames: Sequence[Frame], regions: Sequence[Ellipse]) -> None:
    """Follow regions through the frames, pass by pass; this is the worker."""
    each = _started(frames[0], regions)
    trackers = Trackers(quick_start())
    with contextlib.suppress(EOFError, BrokenPipeError):  # the main program needs no more
        while True:
            trackers.each = [copy.copy(tracker) for tracker in each]
            images = copy.deepcopy(frames[1:])
            pipe.send(None)
            pipe.recv()
            for image in images:
                trackers.update(image)
            pipe.send(None)
