"""Where the microseconds of one update go, and how much there is to do.

    python benchmarks/breakdown.py

Times are those of the real functions in the midst of real updates; what a kernel does step by step
is timed in calls of the kernel's own steps, on the same frames and for all particles at once. A
filter on color alone makes its steps in one call of compiled code; here they are called one by one,
and the last line is of the one call. (This is not called profile.py, which would hide Python's
module.)
"""

from __future__ import annotations

import copy
import statistics
import time
from collections import defaultdict
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from typing import Any
from unittest.mock import patch

import numpy as np

from motes import Tracker, kernels
from motes.core.frame import Frame
from motes.cues.color import ColorModel
from motes.cues.structure_tensor import OrientationModel, filters_of
from motes.kernels.structures import Counts, Floats, Reading, Window
from motes.sot import particle_filter
from motes.sot.algorithm import StepInfo
from motes.sot.particle_filter import ParticleFilter
from motes.sot.presets import preset
from motes.synthetic.clips import still
from motes_lab.report import markdown
from motes_lab.report.tables import NO_VALUE, Cell, Table, number
from motes_lab.speed.measure import MAIN, SIZE, Film, timed

PRESETS = ("nummiaro", "ng_delp", "maggio")
FRAMES, ROUNDS = 31, 10
SELECT, PROPAGATE = "select: resampling", "propagate: random numbers, motion"
COLOR = (
    "color: places of the points",
    "color: pixels gathered",
    "color: bins",
    "color: histogram",
    "color: Bhattacharyya coefficient",
)
DENSE, PLACES, FILL, COMPARE = EDGES = (
    "edges: dense filters",
    "edges: places of the points",
    "edges: gathered, histogram",
    "edges: Bhattacharyya coefficient",
)
WEIGH, ESTIMATE, OWN, LEARN = LAST = (
    "weigh: likelihood, fusion",
    "estimate: mean, covariance",
    "estimate: its own distance",
    "learn: what the next reading takes",
)
ROWS = (SELECT, PROPAGATE, *COLOR, *EDGES, *LAST)
KERNELS = {
    (kernels.sobel, "sobel"): DENSE,
    (kernels.structure_tensor, "structure_tensor"): DENSE,
    (kernels.sobel, "histograms"): FILL,
    (kernels.structure_tensor, "histograms"): FILL,
    (kernels.histograms, "bhattacharyya"): COMPARE,
}
"""Of the cues of edges, each with its row; those of histograms also compute the places."""


def watched(spent: dict[str, float], row: str, function: Callable[..., Any]) -> Callable[..., Any]:
    """Return a function whose seconds are added up in a row."""

    def run(*args: Any) -> Any:
        start = time.perf_counter()
        try:
            return function(*args)
        finally:
            spent[row] += time.perf_counter() - start

    return run


@contextmanager
def watching(config: ParticleFilter) -> Iterator[dict[str, float]]:
    """Time the steps of a particle filter, and what the kernels of its cues do for particles."""
    spent: dict[str, float] = defaultdict(float)
    distances = ParticleFilter._distances
    own = watched(spent, OWN, distances)

    def reading(config: ParticleFilter, models: Any, frame: Frame, ellipses: Any) -> Any:
        if len(ellipses) == 1:
            return own(config, models, frame, ellipses)
        with ExitStack() as stack:
            for (home, name), row in KERNELS.items():
                timed_kernel = watched(spent, row, getattr(home, name))
                stack.enter_context(patch.object(home, name, timed_kernel))
            return distances(config, models, frame, ellipses)

    steps: tuple[tuple[Any, str, str], ...] = (
        (type(config.resampling), "ancestors", SELECT),
        (type(config.motion), "propagate", PROPAGATE),
        (type(config.likelihood), "log", WEIGH),
        (type(config.fusion), "fuse", WEIGH),
        (particle_filter, "mean_ellipse", ESTIMATE),
        (particle_filter, "update_models", LEARN),
    )
    with ExitStack() as stack, step_by_step(), patch.object(ParticleFilter, "_distances", reading):
        for owner, name, row in steps:
            function = watched(spent, row, getattr(owner, name))
            stack.enter_context(patch.object(owner, name, function))
        yield spent


def step_by_step() -> Any:
    """Return a context in which no filter makes its steps in one call."""
    return patch.object(ParticleFilter, "color_step", property(lambda _: None))


def seconds_of(function: Callable[..., object], *arguments: Any) -> float:
    """Return the seconds of a call."""
    start = time.perf_counter()
    function(*arguments)
    return time.perf_counter() - start


def places(window: Window, ellipses: Floats, reading: Reading) -> tuple[Counts, Floats, float]:
    """Return the places (N, P) and weights that ellipses read, and the seconds without the calls.

    What the calls themselves take is told by ellipses that are none.
    """
    shape = len(ellipses), reading.lattice.shape[1]
    offsets, weights = np.empty(shape, np.uint32), np.empty(shape)

    def all_of(these: Floats) -> None:
        for ellipse, to, weigh in zip(these, offsets, weights, strict=True):
            kernels.sampling.pixels_within(window, ellipse, reading, to, weigh)

    calls = seconds_of(all_of, np.full(ellipses.shape, np.nan))
    return offsets, weights, seconds_of(all_of, ellipses) - calls


def color_steps(config: ParticleFilter, frame: Frame, info: StepInfo) -> dict[str, float]:
    """Return the seconds of each step of `kernels.color.distances`, for all particles at once."""
    cue, model = config.color, info.models["color"]
    assert cue is not None
    assert isinstance(model, ColorModel)
    pixels = frame.pixels.copy()  # just written, as by a decoder
    window = 0, 0, frame.width, frame.height, 3, 3 * frame.width
    offsets, weights, first = places(window, info.ellipses, cue.reading)
    colors = np.empty(offsets.size, np.uint32)
    lanes = np.empty((kernels.histograms.LANES, len(model.roots) + 1))
    histograms, distances = np.ones((len(offsets), lanes.shape[1])), np.empty(len(offsets))
    others = (
        (kernels.sampling.colors_at, pixels, offsets.ravel(), colors),
        (kernels.color.to_bins, colors, cue._bins),
        (kernels.histograms.fill, colors, weights.ravel(), model.slots, lanes),
        (kernels.histograms.bhattacharyya, histograms, model.roots, distances),
    )
    return dict(zip(COLOR, [first, *(seconds_of(*call) for call in others)], strict=True))


def plane_of(frame: Frame) -> Any:
    """Return the plane of edges that particles read; what is learned may have needed another."""
    return next(iter(frame.cache.values()))


def edge_places(config: ParticleFilter, frame: Frame, info: StepInfo) -> dict[str, float]:
    """Return the seconds for the places that are read in the plane of edges."""
    cue = config.edges or config.orientation
    assert cue is not None
    plane = plane_of(frame)
    height, width = plane.bins.shape
    window = plane.column, plane.row, width, height, 1, width
    reading = cue.reading
    ellipses = plane.in_blocks(info.ellipses)
    return {PLACES: places(window, ellipses, reading)[2]}


@dataclass(frozen=True)
class Breakdown:
    """Medians over updates.

    Attributes
    ----------
    whole, steps
        Seconds of an update, and of one that makes its steps one by one.
    parts
        By row.
    counts
        How much there is to do in one of them.
    """

    whole: float
    steps: float
    parts: dict[str, float]
    counts: dict[str, int]


def break_down(name: str) -> Breakdown:
    """Take a preset's updates apart."""
    config = preset(name)
    assert isinstance(config, ParticleFilter)
    frames, (region,) = Film.of(still(SIZE, MAIN, FRAMES))
    tracker = Tracker(config)
    tracker.init(frames[0], region)
    whole: list[float] = []
    steps: list[float] = []
    parts: dict[str, list[float]] = defaultdict(list)
    for turn in range(1 + ROUNDS):
        if turn == 1:  # all is imported and warm
            parts.clear()
            whole.clear()
            steps.clear()
        whole += timed(copy.copy(tracker).update, frames[1:])
        with step_by_step():
            steps += timed(copy.copy(tracker).update, frames[1:])
        with watching(config) as spent:
            again = copy.copy(tracker)
            for frame in map(copy.deepcopy, frames[1:]):
                spent.clear()
                again.update(frame)
                info = again.info
                seconds = dict(spent)
                seconds |= color_steps(config, frame, info)
                if frame.cache:
                    seconds |= edge_places(config, frame, info)
                    seconds[FILL] -= seconds[PLACES]
                for row, value in seconds.items():
                    parts[row].append(value)
    return Breakdown(
        statistics.median(whole),
        statistics.median(steps),
        {row: statistics.median(values) for row, values in parts.items()},
        counted(config, frame, info),
    )


def counted(config: ParticleFilter, frame: Frame, info: StepInfo) -> dict[str, int]:
    """Return how much there is to do in an update, as lab/docs/performance.md derives it."""
    cue, model = config.color, info.models["color"]
    assert cue is not None
    assert isinstance(model, ColorModel)
    particles, points, bins = config.particles, cue.sampling.lattice.shape[1], len(model.roots)
    pixels = particles * points
    scattered, dense, blocks, side = 3, 0, 0, 0
    if config.edges:
        scattered, dense = 5, 39
    elif config.orientation:
        learned = info.models["orientation"]
        assert isinstance(learned, OrientationModel)
        filters = filters_of(learned.scale, config.orientation.window)
        r, w = len(filters.smooth) - 1, len(filters.window) - 1
        scattered, dense = 6, 4 * (1 + 4 * r) + 6 * (1 + 4 * w) + 30
    if frame.cache:
        blocks, side = plane_of(frame).bins.size, plane_of(frame).step
    cues = len(config.cues)
    return {
        "particles, N": particles,
        "points of each, P": points,
        "occupied bins of the model, m": bins,
        "pixels gathered, N P": pixels,
        "bytes of these, 3 N P": 3 * pixels,
        "scattered reads, 3 N P; edges 2, orientation 3 more": scattered * pixels,
        "operations for places, 14 N P a cue": 14 * pixels * cues,
        "for bins, 22 N P in HSV": 22 * pixels * (cue.space == "hsv"),
        "for histograms, N P a cue": pixels * cues,
        "for coefficients of color, 4 m N": 4 * bins * particles,
        "blocks under dense filters, A": blocks,
        "pixels in a block, s²": side**2,
        "bytes of all blocks, 3 A s²": 3 * blocks * side**2,
        "operations in a block, c": dense,
        "in all blocks, c A": dense * blocks,
    }


def times(found: dict[str, Breakdown]) -> Table:
    """Return microseconds by row; what no row explains is the rest."""
    rows = []
    for row in ROWS:
        cells = (
            number(1e6 * each.parts[row], 1) if row in each.parts else Cell(NO_VALUE)
            for each in found.values()
        )
        rows.append((Cell(row), *cells))
    rests = (each.steps - sum(each.parts.values()) for each in found.values())
    rows.append(
        (Cell("rest: Python between all these"), *(number(1e6 * rest, 1) for rest in rests))
    )
    feet = (
        (Cell("all, step by step"), *(number(1e6 * each.steps, 1) for each in found.values())),
        (Cell("an update"), *(number(1e6 * each.whole, 1) for each in found.values())),
    )
    return Table("Microseconds of an update", ("part", *found), rows, feet)


def amounts(found: dict[str, Breakdown]) -> Table:
    """Return counts by row."""
    first, *_ = (each.counts for each in found.values())
    rows = [
        (Cell(row), *(Cell(f"{each.counts[row]:,}") for each in found.values())) for row in first
    ]
    return Table(
        "Counts of an update; operations are those of floating point", ("count", *found), rows
    )


def main() -> None:
    found = {name: break_down(name) for name in PRESETS}
    for table in (times(found), amounts(found)):
        print(markdown.table(table), end="\n\n")


if __name__ == "__main__":
    main()
