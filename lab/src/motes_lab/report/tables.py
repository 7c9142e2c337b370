"""Tables of numbers, from which Markdown and CSV are made."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import NamedTuple

from motes_lab.metrics.statistics import Difference, Mean

NO_VALUE = "–"
"""The text of a cell without a number."""


class Cell(NamedTuple):
    """A cell of a table."""

    text: str
    """The text shown."""
    value: float | None = None
    """The number that is shown; None for a text."""
    more: Mapping[str, float] = MappingProxyType({})
    """Further numbers that are shown, by name, such as the upper end of an interval."""
    best: bool = False
    """Whether it is the best of its column."""


Row = tuple[Cell, ...]


@dataclass(frozen=True, slots=True)
class Table:
    """A table with a title."""

    title: str
    """One line."""
    head: tuple[str, ...]
    """Titles of the columns; the first column names the rows."""
    rows: list[Row]
    foot: tuple[Row, ...] = ()
    """Rows, and rows below them."""
    note: str = ""
    """An explanation of the numbers."""


def number(value: Mean | float | None, digits: int = 3) -> Cell:
    """Return a number, with its standard deviation if it has one."""
    mean, deviation = value if isinstance(value, Mean) else (value, math.nan)
    if mean is None or not math.isfinite(mean):
        return Cell(NO_VALUE)
    return _formatted(mean, deviation, f".{digits}f")


def percent(value: Mean | float) -> Cell:
    """Return a share in percent, with its standard deviation if it has one."""
    return _formatted(*(value if isinstance(value, Mean) else (value, math.nan)), ".0%")


def _formatted(mean: float, deviation: float, form: str) -> Cell:
    if math.isnan(deviation):
        return Cell(f"{mean:{form}}", mean)
    text = f"{mean:{form}} ± {deviation:{form}}"
    return Cell(text, mean, {"standard deviation": deviation})


def three_digits(value: float) -> Cell:
    """Return a number with three significant digits, and with all digits before the point."""
    if not math.isfinite(value):
        return Cell(NO_VALUE)
    return Cell(f"{value:.0f}" if value >= 99.95 or not value else f"{value:#.3g}", value)


def difference(found: Difference, digits: int = 3) -> tuple[Cell, Cell]:
    """Return a difference with its sign, and its interval."""
    mean, low, high = found
    form = f"+.{digits}f"
    return (
        Cell(f"{mean:{form}}", mean) if math.isfinite(mean) else Cell(NO_VALUE),
        interval(low, high, form) if math.isfinite(low) else Cell(NO_VALUE),
    )


def interval(low: float, high: float, form: str) -> Cell:
    """Return an interval, its ends in a form such as ".1%"."""
    return Cell(f"{low:{form}} to {high:{form}}", low, {"upper end": high})


def best(cells: Iterable[Cell], sign: int = 1) -> list[Cell]:
    """Return the cells with the best value marked, if there are at least two values.

    Where more is better, a value of 0 is no merit.
    """
    cells = list(cells)
    known = [sign * cell.value for cell in cells if cell.value is not None]
    if len(known) < 2:
        return cells
    top = sign * max(known)
    if sign > 0 and not top:
        return cells
    return [cell._replace(best=cell.value == top) for cell in cells]


def count_noun(number: int, what: str) -> str:
    """Return a number with its noun in singular or plural, such as "2 passes"."""
    plural = "es" if what.endswith("s") else "s"
    return f"{number} {what}{plural if number != 1 else ''}"
