"""The runs of `motes-lab evaluate` with their progress bar, and the writing of their results."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

from motes.cli import DONE, PARTIAL, TerminalBar, log
from motes.core import interrupts
from motes_fleet.cluster import pool as pools
from motes_fleet.cluster.machine import cores
from motes_fleet.cluster.open_pool import open_pool
from motes_lab import mot_scores, runner
from motes_lab.aggregate import Evaluation
from motes_lab.cli.evaluate_options import RunOptions
from motes_lab.datasets.mot import MotSequence
from motes_lab.datasets.sot import Problem
from motes_lab.experiment import show_tables
from motes_lab.mot_scores import MotEvaluation, MotOutcome
from motes_lab.report import mot_sections, sections
from motes_lab.report.markdown import write_report
from motes_lab.report.tables import count_noun
from motes_lab.runner import Job, Pass
from motes_lab.scores import PROTOCOL_NAMES, Outcome, write_results


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
    attempts = 1 if options.cluster is None else pools.ATTEMPTS
    with (
        open_pool(options.cluster, options.workers or cores()) as pool,
        PassProgress(total, total - missing) as progress,
    ):
        for job, failed in runner.run(pool, left, out, options.time_limit, attempts):
            interrupts.check()
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
    title: str,
    interrupted: KeyboardInterrupt | None,
) -> int:
    """Write the results of jobs, print the tables of means, and return the exit code.

    Parameters
    ----------
    jobs, out, errors
        The jobs, in the order of the results; the folder; the passes that failed.
    problems
        What went wrong before.
    title
        The title of the report.
    interrupted
        What stopped the runs, if anything did.
    """
    evaluation: MotEvaluation | Evaluation
    if isinstance(jobs[0].sequence, MotSequence):
        evaluation = MotEvaluation(each for job in jobs for each in MotOutcome.of(job, out, errors))
        mot_scores.write_results(out, evaluation)
        made = {name: mot_sections.tables(evaluation) for name in evaluation.protocols}
    else:
        evaluation = Evaluation(each for job in jobs for each in Outcome.of(job, out, errors))
        write_results(out, evaluation.outcomes)
        made = {name: sections.tables(evaluation, name) for name in evaluation.protocols}
    problems = sections.problems(problems, evaluation.outcomes)
    tables = {PROTOCOL_NAMES[name]: each for name, each in made.items()}
    write_report(out, evaluation, tables, problems, title)
    show_tables(replace(means, title=name) for name, (means, *_) in tables.items())
    for problem in problems:
        log(f"{problem.where}: {problem.what}")
    failed = sum(outcome.trace is None for outcome in evaluation.outcomes)
    log(
        interrupts.word(interrupted)
        + f"{count_noun(len(evaluation.outcomes), 'pass')}, {failed} failed; "
        + f"wrote {out / 'summary.md'}."
        + " Go on with --resume." * (interrupted is not None)
    )
    if interrupted:
        return interrupts.code(interrupted)
    return PARTIAL if problems else DONE
