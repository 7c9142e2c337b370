"""The runner of experiments: results that grow step by step are shown, and written to a folder."""

from __future__ import annotations

import contextlib
import csv
import io
import sys
import time
from collections.abc import Callable, Generator, Iterable, Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

from motes import FormatError
from motes.cli import DONE, PARTIAL, log, options, prepared_folder
from motes.core import interrupts
from motes_lab.datasets.sot import Problem
from motes_lab.inputs import OUTPUT, Overwrite
from motes_lab.report import markdown
from motes_lab.report.tables import Cell, Table
from motes_lab.scores import write_text

if TYPE_CHECKING:
    from matplotlib.figure import Figure

DPI = 110
WIDE = 200
"""Columns of text where there is no terminal: no table needs to be folded."""


class Result(NamedTuple):
    """The results of an experiment so far; each step adds to them."""

    tables: dict[str, Table]
    """By the name of the table in the experiment; "" if there is only one."""
    draw: Callable[[], Figure] | None = None
    """Draws the plot; None for an experiment without a plot."""
    problems: tuple[Problem, ...] = ()
    """Failures that did not stop the experiment."""
    progress: str = ""
    """The progress of the experiment, as text."""
    share: float = 0.0
    """Share of the work that is done; 0 if it is not known."""


Experiment = Generator[Result, None, None]
"""It yields a result after every step; the last one is that of the whole experiment."""


@options(OUTPUT)
class ResultOptions:
    """Where the results are written."""

    out: Path | None = None
    """Folder for the tables, as Markdown and CSV, and for the plots."""
    overwrite: Overwrite = False

    def show(self, name: str, steps: Experiment, problems: Sequence[Problem] = ()) -> int:
        """Run an experiment, show and write its results; return the exit code.

        After an interrupt or an error, these are the results so far.

        Parameters
        ----------
        name
            The name of the files.
        steps
            The experiment, which has not begun.
        problems
            Failures so far.

        Raises
        ------
        FormatError
            If the results cannot be written, which is checked first.
        """
        older = [] if self.out is None else [path.name for path in self.out.glob(f"{name}-*.csv")]
        files = [f"{name}.{ending}" for ending in ("md", "csv", "png")]
        with prepared_folder(self.out, [*files, *older], self.overwrite):
            return self._run(name, steps, problems)

    def _run(self, name: str, steps: Experiment, problems: Sequence[Problem]) -> int:
        from rich.console import Console
        from rich.text import Text

        result: Result | None = None
        start = time.monotonic()
        try:
            with contextlib.closing(steps), Console(stderr=True).status("measuring") as status:
                for latest in steps:
                    interrupts.check()
                    result, share = latest, latest.share
                    left = (time.monotonic() - start) * (1 - share) / share if share else 0.0
                    status.update(Text(f"measuring: {result.progress}{_time_left(left)}"))
        except KeyboardInterrupt as interrupt:
            seconds = time.monotonic() - start
            known = "the results are not complete" if result else "there are no results yet"
            log(f"{interrupts.word(interrupt)}{seconds:.0f} s; {known}.")
            return interrupts.code(interrupt)
        finally:
            with interrupts.deferred():
                if result is not None:
                    self._show(name, result)
                    problems = [*problems, *result.problems]
                for problem in problems:
                    log(f"{problem.where}: {problem.what}")
        return PARTIAL if problems else DONE

    def _show(self, name: str, result: Result) -> None:
        """Write tables and plot into the folder, and print the tables."""
        if not result.tables:
            log("There are no results yet.")
            return
        if self.out is not None:  # first: a reader of the tables, such as `head`, may end early
            save(result, self.out, name)
        show_tables(result.tables.values())
        if self.out is not None:
            plot = "" if result.draw is None else " and PNG"
            log(f"wrote {self.out / name}.md, with CSV{plot}.")
        elif result.draw is not None:
            log("For the plot, give a folder with --out.")


def _time_left(seconds: float) -> str:
    """Return the end of a line of progress: the time that is left, or nothing for 0."""
    if seconds <= 0:
        return ""
    return (
        f", about {seconds:.0f} s left" if seconds < 100 else f", about {seconds / 60:.0f} min left"
    )


def show_tables(tables: Iterable[Table]) -> None:
    """Print tables on standard output."""
    from rich.box import SIMPLE_HEAD
    from rich.console import Console
    from rich.table import Table as Drawn
    from rich.text import Text

    if isinstance(sys.stdout, io.TextIOWrapper):
        sys.stdout.reconfigure(errors="replace")  # not every terminal knows ± and µs
    console = Console()
    if not console.is_terminal:
        console = Console(width=WIDE)
    for table in tables:
        drawn = Drawn(
            title=Text(table.title), caption=Text(table.note), box=SIMPLE_HEAD,
            title_justify="left", caption_justify="left",
        )  # fmt: skip
        for title in table.head:
            drawn.add_column(Text(title), justify="left" if title == table.head[0] else "right")
        for rows in (table.rows, table.foot):
            for row in rows:
                drawn.add_row(*(Text(cell.text) for cell in row))
            drawn.add_section()
        console.print(drawn)


def save(result: Result, folder: Path, name: str) -> None:
    """Write a result into a folder: all tables as NAME.md and each as CSV, the plot as NAME.png.

    Raises
    ------
    FormatError
        If a file cannot be written.
    """
    tables = result.tables
    text = "\n\n".join(markdown.table(table) for table in tables.values())
    write_text(folder / f"{name}.md", f"{text}\n")
    for key, table in tables.items():
        write_text(folder / f"{name}{'-' * bool(key)}{key}.csv", as_csv(table))
    if result.draw is not None:
        path = folder / f"{name}.png"
        try:
            result.draw().savefig(path, dpi=DPI)
        except OSError as error:
            raise FormatError(
                f"The plot {path} cannot be written: {error.strerror}; choose another folder, or "
                f"make room there."
            ) from None


def as_csv(table: Table) -> str:
    """Return a table as CSV; numbers have six significant digits.

    Further numbers of its cells, such as standard deviations, are in columns of their own.
    """
    columns = [
        column
        for title, *cells in zip(table.head, *table.rows, *table.foot, strict=True)
        for column in _columns(title, cells)
    ]
    text = io.StringIO()
    csv.writer(text, lineterminator="\n").writerows(zip(*columns, strict=True))
    return text.getvalue()


def _columns(title: str, cells: Sequence[Cell]) -> Iterator[list[str]]:
    """Yield the columns of CSV that a column of a table needs, each with its title."""
    yield [title, *(cell.text if cell.value is None else _number(cell.value) for cell in cells)]
    for name in dict.fromkeys(name for cell in cells for name in cell.more):
        yield [f"{title}, {name}", *(_number(cell.more.get(name)) for cell in cells)]


def _number(value: float | None) -> str:
    return "" if value is None else f"{value:.6g}"
