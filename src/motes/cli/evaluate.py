"""`motes evaluate`: measure trackers on sequences whose truth is known."""

from __future__ import annotations

import contextlib
import sys
from collections.abc import Iterable, Sequence
from fnmatch import fnmatchcase
from pathlib import Path
from typing import Annotated, Any, Literal, Self

from cyclopts import App, Parameter

from motes.cli.exit_codes import DONE, PARTIAL
from motes.cli.input_checks import check_counts, first_pixels, worker_count
from motes.cli.options import (
    DATASET,
    OUTPUT,
    RUN,
    FirstPixel,
    Overwrite,
    Workers,
    announce_compiling,
    log,
)
from motes.core import interrupts
from motes.core.errors import ConfigError, FormatError, MissingDependencyError, SourceError
from motes.core.interrupts import check
from motes.evaluation import mot_scores, runner
from motes.evaluation.adapters.mot import SCENE
from motes.evaluation.adapters.registry import mot_tracker_spec, resolve, with_detector
from motes.evaluation.adapters.sot import MotesAdapter
from motes.evaluation.aggregate import Evaluation
from motes.evaluation.datasets.distractors import assignment_solver
from motes.evaluation.datasets.mot import MotSequence, has_mot_sequences, load_mot_dataset
from motes.evaluation.datasets.sot import Problem, load_dataset
from motes.evaluation.datasets.sot import Sequence as Film
from motes.evaluation.mot_scores import MotEvaluation, MotOutcome
from motes.evaluation.protocols.perturbations import MAX_FRAMES
from motes.evaluation.protocols.sot import MIN_FRAMES
from motes.evaluation.report import plots
from motes.evaluation.report import sections as report_sections
from motes.evaluation.report import write_mot as mot_report
from motes.evaluation.report.reference import Reference
from motes.evaluation.report.speed_ratio import PEER, Comparisons
from motes.evaluation.report.tables import Table, count_noun
from motes.evaluation.report.write import write_report
from motes.evaluation.run_folder import prepare, record
from motes.evaluation.runner import Job, Pass
from motes.evaluation.scores import Outcome, PassResult, write_results

TRACKERS = """\
Trackers:
  nummiaro, mean_shift:kalman   presets
  FILE.toml                     a configuration, over the preset that it names
  cv2:csrt, cv2:kcf, cv2:mil, cv2:mosse, cv2:medianflow, cv2:camshift
  module:factory                a Python callable; it returns an object with
                                init(image, box) and update(image)
  "trax:COMMAND ARGUMENTS"      a program that speaks TraX
Trackers of many objects:
  trackers:sort, trackers:bytetrack
  module:factory                a Python callable; it returns an object with
                                update(frame, detections)
  results=FOLDER                results that are there: SEQUENCE.txt
"""

app = App(name="evaluate", help_epilogue=TRACKERS, help_format="plaintext")


@app.default
def evaluate(
    dataset: Path,
    /,
    *,
    tracker: Annotated[
        list[str] | None,
        Parameter(
            group=RUN,
            negative=(),
            help="Who is measured, again for each; else nummiaro. To be given for many objects.",
        ),
    ] = None,
    detector: Annotated[
        str | None,
        Parameter(
            group=RUN,
            help="Who finds many objects, in place of det/det.txt: background, or the "
            "module:factory of a Python callable.",
        ),
    ] = None,
    protocol: Annotated[
        list[Literal["ope", "sre", "tre", "reset", "robust"]] | None,
        Parameter(
            group=RUN,
            negative=(),
            help="One pass, perturbed starts, perturbed times, restarted after failures, "
            "24 views; again for each; else ope.",
        ),
    ] = None,
    robust: Annotated[
        bool,
        Parameter(group=RUN, negative=(), show_default=False, help="Short for --protocol robust."),
    ] = False,
    max_frames: Annotated[
        int, Parameter(group=RUN, help="Of each view of the protocol robust; 5 or more.")
    ] = MAX_FRAMES,
    seeds: Annotated[int, Parameter(group=RUN, help="Runs of a tracker that draws numbers.")] = 5,
    workers: Workers = None,
    time_limit: Annotated[
        float,
        Parameter(
            group=RUN,
            help="Seconds for a tracker on a sequence in a protocol; in robust, on each view.",
        ),
    ] = runner.TIME_LIMIT,
    sequence: Annotated[
        list[str] | None,
        Parameter(group=DATASET, negative=(), help="Only these, as in 'seg-*'; again for each."),
    ] = None,
    annotation: Annotated[
        Path | None, Parameter(group=DATASET, help="The truth, if DATASET is one video.")
    ] = None,
    first_pixel: FirstPixel = None,
    out: Annotated[Path, Parameter(group=OUTPUT, help="Folder for everything.")] = Path(
        "evaluation"
    ),
    reference: Annotated[
        Path | None,
        Parameter(group=OUTPUT, help="CSV file of other people's numbers, for the report."),
    ] = None,
    peer: Annotated[
        str | None,
        Parameter(
            group=OUTPUT,
            help=f"The tracker whose time the others are set against; else {PEER}, if it "
            "takes part.",
        ),
    ] = None,
    folds: Annotated[
        int | None,
        Parameter(
            group=OUTPUT,
            help="Choose among presets and configurations on all but one of so many parts of the "
            "dataset, and report on that one.",
        ),
    ] = None,
    resume: Annotated[
        bool,
        Parameter(
            group=OUTPUT,
            negative=(),
            show_default=False,
            help="Keep the tracks that are there already, and run what is missing. Trackers, "
            "protocols, sequences and seeds may be added.",
        ),
    ] = False,
    overwrite: Overwrite = False,
) -> int:
    """Measure trackers on sequences whose truth is known.

    Writes results.csv, summary.md, report.html and each track (tracks/) into a folder. A sequence
    or tracker that fails is named, and the others go on.

    Parameters
    ----------
    dataset
        A folder of sequences in the layouts of OTB, VOT, GOT-10k or, with many objects, MOT; or a
        video with --annotation.
    """
    check_counts(seeds=seeds)
    if max_frames < MIN_FRAMES:
        raise ConfigError(f"--max-frames is {max_frames}; give {MIN_FRAMES} or more.")
    if robust:
        protocol = [*(protocol or []), "robust"]
    processes = worker_count(workers)
    if not 0 < time_limit < float("inf"):
        raise ConfigError(f"--time-limit is {time_limit:g}; give a number of seconds.")
    if not plots.has_matplotlib():
        raise MissingDependencyError(
            "The report needs matplotlib; install it: pip install 'motes[report]'."
        )
    many = has_mot_sequences(dataset)
    single: dict[str, object] = {
        "protocol": protocol,
        "annotation": annotation,
        "first-pixel": first_pixel,
        "reference": reference,
        "peer": peer,
        "folds": folds,
    }
    _check_kind(many, tracker, single, {"detector": detector})
    if peer is not None and peer not in (tracker or ()):
        raise ConfigError(f"--peer {peer} takes no part; give --tracker {peer} as well.")
    published = None if reference is None else _load(reference)

    films: Sequence[Film | MotSequence]
    if many:
        films, problems = load_mot_dataset(dataset)
    else:
        films, problems = load_dataset(dataset, first_pixels(first_pixel or []), annotation)
    films, problems = _chosen(films, problems, sequence or ["*"])
    entries, unusable = resolve(tracker or ["nummiaro"], mot_tracker_spec if many else None)
    if not entries:
        raise ConfigError("There is no tracker to run. " + _lines(unusable))
    if detector is not None:
        entries = with_detector(entries, detector)
    protocols = ["mot"] if many else list(dict.fromkeys(protocol or ["ope"]))
    jobs, unreadable = runner.plan(entries, films, protocols, seeds, max_frames)
    problems += unreadable
    if not jobs:
        raise SourceError(f"No sequence of {dataset} can be used. " + _lines(problems))
    problems += unusable
    candidates = tuple(entry.name for entry in entries if entry.make.func is MotesAdapter)
    if folds is not None:
        _check_folds(folds, len({job.sequence.name for job in jobs}), candidates)
    now = record(dataset, jobs, entries, protocols, seeds, time_limit, max_frames)
    prepare(out, now, resume=resume, overwrite=overwrite)

    if any(entry.make.func is MotesAdapter or entry.name == SCENE for entry in entries):
        announce_compiling()
    errors: dict[Pass, str] = {}
    interrupted: KeyboardInterrupt | None = None
    try:
        _run(jobs, out, processes, time_limit, errors)
    except KeyboardInterrupt as interrupt:
        interrupted = interrupt
    # The first tracker first.
    jobs = [job for entry in entries for job in jobs if job.spec is entry]
    title = f"Trackers on {dataset.resolve().name}"
    outcomes: list[Outcome] | list[MotOutcome]
    if many:
        outcomes = [outcome for job in jobs for outcome in MotOutcome.of(job, out, errors)]
        crowds = MotEvaluation(outcomes)
        mot_scores.write_results(out, crowds)
        mot_report.write_report(out, crowds, problems, title)
        tables = {
            report_sections.title(crowds, name): mot_report.overall(crowds)
            for name in crowds.protocols
        }
    else:
        outcomes = [outcome for job in jobs for outcome in Outcome.of(job, out, errors)]
        write_results(out, outcomes)
        wanted = Comparisons(published, peer or PEER, candidates, folds or 0)
        write_report(out, outcomes, problems, wanted, title)
        found = Evaluation(outcomes)
        tables = {
            report_sections.title(found, name): report_sections.overall(found, name)
            for name in found.protocols
        }
    problems = report_sections.problems(problems, outcomes)
    _summarize(tables, outcomes, problems, out, interrupted=interrupted)
    if interrupted:
        return interrupts.code(interrupted)
    return PARTIAL if problems else DONE


def _check_kind(
    many: bool, tracker: list[str] | None, single: dict[str, object], crowds: dict[str, object]
) -> None:
    """Check that options are for this kind of dataset, one object or many, and all is there."""
    kinds = ["one object", "many objects"]
    for name, value in (single if many else crowds).items():
        if value is not None:
            raise ConfigError(
                f"--{name} is for datasets with {kinds[not many]}, but this has {kinds[many]}; "
                f"leave it out."
            )
    if many and not tracker:
        raise ConfigError(
            "There is no tracker; name some, such as --tracker trackers:sort --tracker "
            "trackers:bytetrack."
        )
    if many:
        assignment_solver()


def _check_folds(folds: int, sequences: int, candidates: Sequence[str]) -> None:
    """Check that there is something to choose, and to choose it on."""
    if not 2 <= folds <= sequences:
        raise ConfigError(
            f"--folds is {folds}; give 2 or more, but no more than the {sequences} sequences."
        )
    if len(candidates) < 2:
        raise ConfigError(
            "--folds chooses among presets and configurations of motes; name two or more with "
            "--tracker."
        )


def _load(reference: Path) -> Reference:
    try:
        return Reference.load(reference)
    except FormatError as error:
        raise SourceError(str(error)) from None


def _chosen(
    films: Sequence[Film | MotSequence], problems: list[Problem], patterns: Sequence[str]
) -> tuple[list[Film | MotSequence], list[Problem]]:
    """Return the sequences that fit one of the patterns, and their problems."""
    names = {film.name for film in films}
    names |= {problem.where.removeprefix("sequence ") for problem in problems}
    for pattern in patterns:
        if not any(fnmatchcase(name, pattern) for name in names):
            raise ConfigError(
                f"--sequence {pattern} fits none of {', '.join(sorted(names)[:9])}"
                + " …." * (len(names) > 9)
            )
    chosen = {name for name in names for pattern in patterns if fnmatchcase(name, pattern)}
    return (
        [film for film in films if film.name in chosen],
        [problem for problem in problems if problem.where.removeprefix("sequence ") in chosen],
    )


def _lines(problems: Iterable[Problem]) -> str:
    return "; ".join(f"{problem.where}: {problem.what.rstrip('.')}" for problem in problems) + "."


def _run(
    jobs: list[Job], out: Path, workers: int, time_limit: float, errors: dict[Pass, str]
) -> None:
    """Do what is not done yet; `errors` gets those of the passes that failed."""
    left = runner.unfinished(jobs, out)
    total, missing = (sum(len(job.passes) for job in each) for each in (jobs, left))
    steps = runner.run(left, out, workers, time_limit)
    with Progress(total, total - missing) as progress, contextlib.closing(steps):
        for job, failed in steps:
            check()
            if failed is None:
                progress.begin(job)
            else:
                errors |= failed
                progress.end(job, len(failed))


class Progress:
    """A progress bar on standard error; nothing at all where that is no terminal."""

    def __init__(self, total: int, done: int) -> None:
        self._bar: Any = None
        self._failures = 0
        if not sys.stderr.isatty():
            return
        from rich.console import Console
        from rich.progress import BarColumn, TextColumn, TimeRemainingColumn
        from rich.progress import Progress as Bar

        self._bar = Bar(
            TextColumn("{task.completed:.0f}/{task.total:.0f} passes"),
            BarColumn(),
            TimeRemainingColumn(compact=True),
            TextColumn("{task.fields[failures]} failed"),
            TextColumn("{task.description}", markup=False),
            console=Console(stderr=True),
            transient=True,
        )
        self._task = self._bar.add_task("", total=total, completed=done, failures=0)

    def begin(self, job: Job) -> None:
        """Show what is being done."""
        if self._bar is not None:
            self._bar.update(self._task, description=job.name)

    def end(self, job: Job, failures: int) -> None:
        """Count a job's passes, and those that failed."""
        self._failures += failures
        if self._bar is not None:
            self._bar.update(self._task, advance=len(job.passes), failures=self._failures)

    def __enter__(self) -> Self:
        if self._bar is not None:
            self._bar.start()
        return self

    def __exit__(self, *_: object) -> None:
        if self._bar is not None:
            self._bar.stop()


def _summarize(
    tables: dict[str, Table],
    outcomes: Sequence[PassResult[Any, Any]],
    problems: list[Problem],
    out: Path,
    *,
    interrupted: KeyboardInterrupt | None,
) -> None:
    """Print the tables under their titles on standard output, and problems on standard error."""
    for title, table in tables.items():
        rows = [table.head, *([cell.text for cell in row] for row in table.rows)]
        widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
        _print(f"{title}:")
        for first, *others in rows:
            cells = [cell.rjust(width) for cell, width in zip(others, widths[1:], strict=True)]
            _print("  ".join(["", first.ljust(widths[0]), *cells]))
    for problem in problems:
        log(f"{problem.where}: {problem.what}")
    failed = sum(outcome.trace is None for outcome in outcomes)
    log(
        interrupts.word(interrupted)
        + f"{count_noun(len(outcomes), 'pass')}, {failed} failed; wrote {out / 'report.html'}."
    )


def _print(line: str) -> None:
    """Print a line on standard output, whatever characters that knows."""
    encoding = sys.stdout.encoding or "utf-8"
    print(line.encode(encoding, errors="replace").decode(encoding))
