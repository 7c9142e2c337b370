"""The results of `motes-lab experiment` and `motes-lab bench`: printed and written to a folder."""

from __future__ import annotations

import contextlib
import io
import sys
import time
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from cyclopts import Parameter

from motes.cli.exit_codes import DONE, PARTIAL
from motes.cli.input_checks import prepare_folder
from motes.cli.messages import log
from motes.cli.options import OUTPUT, Overwrite
from motes.core import interrupts
from motes.core.interrupts import check, deferred

if TYPE_CHECKING:
    from motes_lab.datasets.sot import Problem
    from motes_lab.papers.expected_time import Expected
    from motes_lab.papers.result import Experiment, Result
    from motes_lab.report.tables import Table

WIDE = 200
"""Columns of text where there is no terminal: no table needs to be folded."""


@Parameter(name="*", group=OUTPUT)
@dataclass(frozen=True, kw_only=True)
class ResultOptions:
    """Where the results are written."""

    out: Annotated[
        Path | None,
        Parameter(help="Folder for the tables, as Markdown and CSV, and for the plots."),
    ] = None
    overwrite: Overwrite = False

    def output(self, name: str, *tables: str, plot: bool = False) -> Output:
        """Return the output of an experiment; raise a FormatError if it cannot be written."""
        return Output(name, tables or ("",), self.out, self.overwrite, plot=plot)


class Output:
    """The folder of the results; it checks on construction that they can be written.

    Parameters
    ----------
    name, tables, plot
        The experiment's name, the keys of its tables, and whether it has a plot.
    folder
        The folder; None to print only.
    overwrite
        Whether existing files may be replaced.
    """

    def __init__(
        self,
        name: str,
        tables: Sequence[str],
        folder: Path | None,
        overwrite: bool,
        *,
        plot: bool = False,
    ) -> None:
        self._name, self._folder, self._plot = name, folder, plot
        if folder is None:
            return
        from motes_lab.papers.result import files

        prepare_folder(folder, files(name, tables, plot), overwrite)

    def show(self, result: Result) -> None:
        """Write tables and plots into the folder, and print the tables."""
        if not result.tables:
            log("There are no results yet.")
            return

        if self._folder is not None:  # first: a reader of the tables, such as `head`, may end early
            from motes_lab.papers.result import save

            save(result, self._folder, self._name)
        from rich.console import Console

        if isinstance(sys.stdout, io.TextIOWrapper):
            sys.stdout.reconfigure(errors="replace")  # not every terminal knows ± and µ
        console = Console()
        if not console.is_terminal:
            console = Console(width=WIDE)
        for table in result.tables.values():
            console.print(_rich(table))
        if self._folder is not None:
            log(f"wrote {self._folder / self._name}.md, with CSV{' and PNG' * self._plot}.")
        elif self._plot:
            log("For the plot, give a folder with --out.")


def show(
    steps: Experiment,
    output: Output,
    problems: Sequence[Problem] = (),
    expected: Expected | None = None,
    *,
    full: bool = True,
) -> int:
    """Run an experiment and show its results; after an interrupt, the results so far.

    Parameters
    ----------
    steps, output
        The experiment, and where its results go.
    problems
        Failures so far.
    expected, full
        How long it will take, which is printed, and whether that is for the whole table.
    """
    from rich.console import Console
    from rich.text import Text

    result: Result | None = None
    start = time.monotonic()
    if expected is not None:
        log(f"{expected}.{'' if full else ' The whole table: --full.'}")
    first = Text(f"measuring{time_left(0.0 if expected is None else expected.seconds)}")
    try:
        with contextlib.closing(steps), Console(stderr=True).status(first) as status:
            for latest in steps:
                check()
                result = latest
                share, passed = result.share, time.monotonic() - start
                left = time_left(passed * (1 - share) / share if share else 0.0)
                status.update(Text(f"measuring: {result.progress}{left}"))
    except KeyboardInterrupt as interrupt:
        return interrupts.code(interrupt)
    finally:
        with deferred():
            if result is not None:
                output.show(result)
                problems = [*problems, *result.problems]
            for problem in problems:
                log(f"{problem.where}: {problem.what}")
    return PARTIAL if problems else DONE


def time_left(seconds: float) -> str:
    """Return the end of a line of progress: the time that is left, or nothing for 0."""
    from motes_lab.papers.expected_time import duration

    return f", about {duration(seconds)} left" if seconds > 0 else ""


def _rich(table: Table) -> object:
    """Return a table for the terminal."""
    from rich.box import SIMPLE_HEAD
    from rich.table import Table as Drawn
    from rich.text import Text

    drawn = Drawn(
        title=Text(table.title), caption=Text(table.note), box=SIMPLE_HEAD, title_justify="left",
        caption_justify="left",
    )  # fmt: skip
    for title in table.head:
        drawn.add_column(Text(title), justify="left" if title == table.head[0] else "right")
    for row in table.rows:
        drawn.add_row(*(Text(cell.text) for cell in row))
    drawn.add_section()
    for row in table.foot:
        drawn.add_row(*(Text(cell.text) for cell in row))
    return drawn
