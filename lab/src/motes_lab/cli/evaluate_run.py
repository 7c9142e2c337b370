"""The runs of `motes-lab evaluate` with their progress bar, and the writing of their results."""

from __future__ import annotations

import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from motes.cli.exit_codes import DONE, PARTIAL
from motes.cli.input_checks import worker_count
from motes.cli.messages import log
from motes.cli.progress import TerminalBar
from motes.cluster.open_pool import open_pool
from motes.cluster.pool import ATTEMPTS
from motes.core import interrupts
from motes.core.interrupts import check
from motes_lab import mot_scores, runner
from motes_lab.aggregate import Evaluation
from motes_lab.cli.evaluate_options import RunOptions
from motes_lab.datasets.mot import MotSequence
from motes_lab.datasets.sot import Problem
from motes_lab.mot_scores import MotEvaluation, MotOutcome
from motes_lab.report import sections as report_sections
from motes_lab.report import write_mot as mot_report
from motes_lab.report.speed_ratio import Comparisons
from motes_lab.report.tables import Table, count_noun
from motes_lab.report.write import write_report
from motes_lab.runner import Job, Pass
from motes_lab.scores import Outcome, PassResult, write_results


def run_jobs(jobs: list[Job], out: Path, options: RunOptions, errors: dict[Pass, str]) -> None:
    """Run the passes that are not done yet.

    Parameters
    ----------
    jobs
        All jobs.
    out
        The folder of the results.
    options
        The workers, and the time limit of a tracker on a sequence in a protocol.
    errors
        Gets the errors of the passes that failed; it is filled also if this is interrupted.
    """
    left = runner.unfinished(jobs, out)
    total, missing = (sum(len(job.passes) for job in each) for each in (jobs, left))
    # A tracker that ends its process has failed. A node of a cluster may die without its fault.
    attempts = 1 if options.cluster is None else ATTEMPTS
    with (
        open_pool(options.cluster, worker_count(options.workers)) as pool,
        PassProgress(total, total - missing) as progress,
    ):
        for job, failed in runner.run(pool, left, out, options.time_limit, attempts):
            check()
            if failed is None:
                progress.begin(job)
            else:
                errors |= failed
                progress.end(job, len(failed))


class PassProgress(TerminalBar):
    """The progress of an evaluation over passes."""

    def __init__(self, total: int, done: int) -> None:
        super().__init__("passes", total, done)
        self._failures, self._job = 0, ""

    def begin(self, job: Job) -> None:
        """Show the job that runs."""
        self._job = job.name
        self._show()

    def end(self, job: Job, failures: int) -> None:
        """Count the passes of a job, and those that failed."""
        self._failures += failures
        self._show(advance=len(job.passes))

    def _show(self, **values: int) -> None:
        self.update(state=f"{self._failures} failed {self._job}", **values)


def write_all(
    jobs: list[Job],
    out: Path,
    errors: dict[Pass, str],
    problems: list[Problem],
    comparisons: Comparisons,
    title: str,
    interrupted: KeyboardInterrupt | None,
) -> int:
    """Write the results of jobs, print a summary, and return the exit code.

    Parameters
    ----------
    jobs, out, errors
        The jobs, in the order of the results; the folder; the passes that failed.
    problems
        What went wrong before.
    comparisons, title
        The optional parts of the report on one object, and its title.
    interrupted
        What stopped the runs, if anything did.
    """
    outcomes: list[Any]
    if isinstance(jobs[0].sequence, MotSequence):
        outcomes = [each for job in jobs for each in MotOutcome.of(job, out, errors)]
        crowds = MotEvaluation(outcomes)
        mot_scores.write_results(out, crowds)
        mot_report.write_report(out, crowds, problems, title)
        tables = {
            report_sections.title(crowds, name): mot_report.overall(crowds)
            for name in crowds.protocols
        }
    else:
        outcomes = [each for job in jobs for each in Outcome.of(job, out, errors)]
        write_results(out, outcomes)
        write_report(out, outcomes, problems, comparisons, title)
        found = Evaluation(outcomes)
        tables = {
            report_sections.title(found, name): report_sections.overall(found, name)
            for name in found.protocols
        }
    return _summarize(tables, outcomes, problems, out, interrupted)


def _summarize(
    tables: dict[str, Table],
    outcomes: Sequence[PassResult[Any, Any]],
    problems: list[Problem],
    out: Path,
    interrupted: KeyboardInterrupt | None,
) -> int:
    """Print the tables on standard output and problems on standard error; return the exit code."""
    problems = report_sections.problems(problems, outcomes)
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
    if interrupted:
        return interrupts.code(interrupted)
    return PARTIAL if problems else DONE


def _print(line: str) -> None:
    """Print a line on standard output, with ? for characters that its encoding lacks."""
    encoding = sys.stdout.encoding or "utf-8"
    print(line.encode(encoding, errors="replace").decode(encoding))
