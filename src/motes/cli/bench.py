"""`motes bench`: the speed of trackers on this machine, side by side in one run."""

from __future__ import annotations

import itertools
import time
from collections.abc import Mapping, Sequence
from functools import partial
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Annotated

from cyclopts import Parameter

from motes.cli.experiment_output import Output, ResultOptions, show
from motes.cli.input_checks import check_counts, read_text
from motes.cli.options import FLAG, OUTPUT, RUN
from motes.core.errors import ConfigError, SourceError
from motes.core.frame import FRAME_INTERVAL
from motes.core.geometry import Ellipse
from motes.evaluation.adapters.opencv import peer
from motes.evaluation.datasets.sot import Problem, load_dataset
from motes.evaluation.datasets.sot import Sequence as TrueSequence
from motes.evaluation.papers.result import Experiment, Result
from motes.evaluation.report.tables import Table
from motes.evaluation.speed import measure as speed
from motes.evaluation.speed import plot as speed_plot
from motes.evaluation.speed import report as speed_report
from motes.evaluation.speed.measure import LARGE, MAIN, SIZE, Film, Job, Run
from motes.evaluation.speed.report import Growth, Ratio, named_size
from motes.evaluation.synthetic.clips import crowd, still
from motes.sot.batch import Trackers
from motes.video.prefetch import prefetch
from motes.video.sources import open_source
from motes.video.writer import VideoWriter

TABLES = ("trackers", "targets", "particles", "files")
UPDATES = 5
"""Updates of a crowd in each round: those of a thousand targets take seconds."""
LENGTH, LARGE_LENGTH = 400, 100
"""Frames of the files."""


def bench(
    *,
    frames: Annotated[int, Parameter(group=RUN, help="Frames of each clip.")] = 31,
    rounds: Annotated[int, Parameter(group=RUN, help="Number of measurements of each job.")] = 3,
    against: Annotated[
        Path | None,
        Parameter(
            group=RUN,
            help="bench.md of another run; its ratios to the peers are compared with those of this "
            "run.",
        ),
    ] = None,
    data: Annotated[
        Path | None,
        Parameter(
            group=RUN,
            env_var="MOTES_DATA",
            help=f"Folder with real sequences for another table: {', '.join(speed.SEQUENCES)}; "
            "its subfolder sot also serves.",
        ),
    ] = None,
    nano: Annotated[
        str | None,
        Parameter(
            group=RUN,
            help="ONNX files of NanoTrack, BACKBONE,HEAD; it then also runs on real sequences.",
        ),
    ] = None,
    vit: Annotated[
        str | None,
        Parameter(
            group=RUN,
            help="ONNX file of VitTrack; it then also runs on real sequences.",
        ),
    ] = None,
    plot: Annotated[
        bool,
        FLAG,
        Parameter(group=OUTPUT, help="Draw plots too; without --out they are in bench/."),
    ] = False,
    results: ResultOptions = ResultOptions(),
) -> int:
    """Measure trackers side by side on rendered clips, and how their time grows.

    The tables show one update of each tracker and of OpenCV's, on rendered clips and, with --data,
    on real sequences; updates of 1 to 1,000 targets in one and two threads, and of 50 to 5,000
    particles; and video files that are decoded, with and without tracking. Each job runs once in
    every round. A time is the median over all updates; it
    is measured inside the tracker.
    """
    check_counts(frames=frames, rounds=rounds)
    if frames < 3:
        raise ConfigError("Medians need --frames of 3 or more.")
    stored = None if against is None else speed_report.stored_ratios(read_text(against), against)
    sequences = [] if data is None else _sequences(data)
    networks: list[str] = []
    for option, files in (("nano", nano), ("vit", vit)):
        if files is not None:
            if data is None:
                raise ConfigError(
                    f"--{option} needs real sequences; give their folder with --data."
                )
            networks.append(f"cv2:{option}={files}")
            peer(networks[-1])  # refuses files that cannot be used
    extra = {"sequences": data is not None, "against": stored is not None}
    tables = (*TABLES, *(name for name, wanted in extra.items() if wanted))
    folder = results.out or (Path("bench") if plot else None)
    output = Output("bench", tables, folder, results.overwrite, plot=plot)
    return show(_measured(frames, rounds, stored, plot, sequences, networks), output)


def _sequences(folder: Path) -> list[TrueSequence]:
    """Return the real sequences in a folder that are measured."""
    place = folder / "sot" if (folder / "sot").is_dir() else folder
    found, problems = load_dataset(place)
    chosen = [sequence for sequence in found if sequence.name in speed.SEQUENCES]
    if not chosen:
        known = ", ".join(speed.SEQUENCES)
        text = "; ".join(f"{problem.where}: {problem.what}" for problem in problems)
        raise SourceError(f"--data {folder} has none of the sequences {known}. {text}".strip())
    return chosen


def _measured(
    frames: int,
    rounds: int,
    stored: Mapping[Ratio, float] | None,
    plot: bool,
    sequences: Sequence[TrueSequence],
    networks: Sequence[str],
) -> Experiment:
    """Yield the results after each round; `stored` are the ratios of another run."""
    tables: dict[str, Table] = {}
    growths: dict[str, Growth] = {}
    updates: dict[Job, list[float]] = {}
    problems: dict[Problem, None] = {}

    def result(progress: str) -> Result:
        draw = partial(speed_plot.figure, updates, [*growths.values()])
        return Result({**tables}, draw if plot else None, (*problems,), progress)

    films = {target: Film.of(still(SIZE, target, frames)) for target in speed.TARGETS}
    jobs, missing = speed.trackers(films)
    for updates in speed.interleaved(jobs, rounds):
        tables["trackers"] = speed_report.trackers_table(updates, missing)
        if stored is not None:
            tables["against"] = speed_report.against(tables["trackers"], stored)
        yield result("trackers")

    if sequences:
        names, missing = speed.available([*speed.RIVALS, *networks])
        names = [*speed.FOLLOWERS, *names]
        real: dict[tuple[str, str], list[float]] = {}
        for _, sequence in itertools.product(range(rounds), sequences):
            found, failed = speed.in_lockstep(names, sequence, frames)
            problems.update(dict.fromkeys(failed))
            for name, times in found.items():
                real.setdefault((sequence.name, name), []).extend(times)
            tables["sequences"] = speed_report.sequences_table(real, missing)
            yield result(f"sequences, {sequence.name}")

    main, many = films[MAIN], Film.of(crowd(LARGE, MAIN))
    few = many._replace(frames=many.frames[: UPDATES + 1])
    for what, steps in (("targets", speed.targets(few)), ("particles", speed.particles(main))):
        for seconds in speed.interleaved(steps, rounds):
            growths[what] = Growth.over(what, seconds)
            tables[what] = growths[what].table()
            yield result(what)

    with TemporaryDirectory(prefix="motes-") as folder:
        files: dict[tuple[str, str], Run] = {}
        for name, film, targets, length in (
            (f"{named_size(SIZE)}, one target", main, 1, LENGTH),
            (f"{named_size(LARGE)}, ten targets", many, 10, LARGE_LENGTH),
        ):
            path = Path(folder) / f"{targets}.mp4"
            _write(path, film, length)
            files[name, "decoded"] = partial(_decode, path)
            files[name, "followed"] = partial(_follow, path, film.regions[:targets])
        for paces in speed.interleaved(files, rounds):
            tables["files"] = speed_report.files_table(paces)
            yield result("files")


def _write(path: Path, film: Film, length: int) -> None:
    """Write a file of `length` frames, in which a film is repeated."""
    with VideoWriter(path, 1 / FRAME_INTERVAL) as writer:
        for frame in itertools.islice(itertools.cycle(film.frames), length):
            writer.write(frame.pixels)


def _decode(path: Path) -> list[float]:
    """Return the mean time to decode a frame of a file, in seconds."""
    start = time.perf_counter()
    with open_source(path) as source:
        count = sum(1 for _ in source)
    return [(time.perf_counter() - start) / count]


def _follow(path: Path, regions: Sequence[Ellipse]) -> list[float]:
    """Return the same with tracking, while a thread decodes ahead as in `motes track`."""
    start = time.perf_counter()
    with open_source(path) as source, prefetch(source) as frames:
        trackers = Trackers(speed.quick_start_config())
        trackers.init(next(frames), regions)
        count = 1 + sum(1 for _ in map(trackers.update, frames))
    return [(time.perf_counter() - start) / count]
