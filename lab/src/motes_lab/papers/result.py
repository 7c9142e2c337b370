"""The results of an experiment, and their files."""

from __future__ import annotations

import csv
import io
from collections.abc import Callable, Generator, Iterable
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from motes.core.errors import FormatError
from motes_lab.aggregate import Mean
from motes_lab.datasets.sot import Problem
from motes_lab.report import markdown
from motes_lab.report.tables import Cell, Table
from motes_lab.scores import write_text

if TYPE_CHECKING:
    from matplotlib.figure import Figure

DPI = 110


class Result(NamedTuple):
    """The results of an experiment so far; each step adds to them.

    Attributes
    ----------
    tables
        By the name of the table in the experiment; "" if there is only one.
    draw
        Draws the plot; None for an experiment without a plot.
    problems
        Failures that did not stop the experiment.
    progress
        The progress of the experiment, as text.
    share
        Share of the work that is done; 0 if it is not known.
    """

    tables: dict[str, Table]
    draw: Callable[[], Figure] | None = None
    problems: tuple[Problem, ...] = ()
    progress: str = ""
    share: float = 0.0


Experiment = Generator[Result, None, None]
"""It yields a result after every step; the last one is that of the whole experiment."""


def over(values: Iterable[float]) -> Mean:
    """Return mean and standard deviation of values."""
    return Mean.over(np.array([*values], np.float64))


def wilson_interval(successes: int, total: int) -> tuple[float, float]:
    """Return the 95 % interval of a share, from 0 to 1, after Wilson, J. Am. Stat. Assoc. 1927."""
    from scipy.stats import binomtest  # takes a second to import

    low, high = binomtest(successes, total).proportion_ci(method="wilson")
    return float(low), float(high)


def files(name: str, tables: Iterable[str], plot: bool) -> list[str]:
    """Return the names of the files of an experiment's results."""
    return [f"{name}.md", *(_csv_name(name, table) for table in tables), *[f"{name}.png"] * plot]


def _csv_name(name: str, table: str) -> str:
    return f"{name}-{table}.csv" if table else f"{name}.csv"


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
        write_text(folder / _csv_name(name, key), as_csv(table))
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

    If a number in a column has a standard deviation, the next column holds the deviations.
    """
    rows = [*table.rows, *table.foot]
    spread = [any(row[i].deviation is not None for row in rows) for i in range(len(table.head))]
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(
        name
        for title, wide in zip(table.head, spread, strict=True)
        for name in ([title, f"{title}, standard deviation"] if wide else [title])
    )
    for row in rows:
        writer.writerow(
            field
            for cell, wide in zip(row, spread, strict=True)
            for field in ([_field(cell), _number(cell.deviation)] if wide else [_field(cell)])
        )
    return text.getvalue()


def _field(cell: Cell) -> str:
    return cell.text if cell.value is None else _number(cell.value)


def _number(value: float | None) -> str:
    return "" if value is None else f"{value:.6g}"
