"""Rows of tracks back from a file: what `motes track` and `motes watch` write."""

from __future__ import annotations

import csv
import io
import math
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any, Literal, overload

import msgspec
import numpy as np
from numpy.typing import NDArray

from motes.core.callables import optional
from motes.core.errors import InputError
from motes.core.files import as_path, check_ended, lines_of, read_text
from motes.core.labels import check_label, unguarded
from motes.rows.schema import NUMBERS, TEXT, WHOLE, Form, form_of

OLD_LINES = "its lines end in carriage returns alone; save it anew, in UTF-8"
SEPARATED = "its columns are separated by {!r}; write commas, and decimal points"
"""What is wrong with a table of a spreadsheet whose numbers have decimal commas."""
TYPES: dict[str, type] = {
    **dict.fromkeys(WHOLE, np.int64),
    **dict.fromkeys(TEXT, np.str_),
    **dict.fromkeys(NUMBERS, np.float64),
}


# Editors show the docstring of the overload that fits a call.
@overload
def read_track(  # noqa: D418
    path: str | Path, *, pandas: Literal[False] = False
) -> NDArray[np.void]:
    """Return the rows as a structured array."""


@overload
def read_track(path: str | Path, *, pandas: Literal[True]) -> Any:  # noqa: D418
    """Return the rows as a DataFrame."""


def read_track(path: str | Path, *, pandas: bool = False) -> Any:
    """Return the rows of a file of tracks (.csv, .jsonl or .parquet), in the order of the file.

    The columns have the names in the file, which are those of `Track.to_dict`.
    `frame` and `id` are whole numbers, `label`, `status` and
    `camera` text, all others floating-point numbers. An empty field is NaN, as the position where
    there was no track yet, or `occluded_by` where no object is in front.

    Parameters
    ----------
    path
        A file of `TrackWriter`, `motes track` or `motes watch`.
    pandas
        Return a `pandas.DataFrame` instead of a structured array of numpy.

    Returns
    -------
    A structured array (rows,), with a field for each column; or a DataFrame.

    Raises
    ------
    ConfigError
        If the ending of the file is none of these.
    InputError
        If the file cannot be read or holds other rows.
    MissingDependencyError
        If pandas, for a DataFrame, or pyarrow, for Parquet, is not installed.
    """
    if as_path(path).suffix.lower() == ".parquet":
        table = _read(path, _parquet_rows(path))
    else:
        form = form_of(path)
        table = table_of(read_text(path, InputError, newline=""), path, form)
    if not pandas:
        return table
    made = optional("pandas", "A DataFrame needs pandas", "pandas").DataFrame
    return made({name: table[name] for name in table.dtype.names or ()})


def table_of(text: str, path: str | Path, form: Form) -> NDArray[np.void]:
    """Return the rows of a text as `read_track` does; raise an InputError if it holds others.

    `path` is its name in messages.
    """
    return _read(path, _csv_lines(text) if form == "csv" else _json_lines(text))


def _read(path: str | Path, lines: Iterator[Sequence[Any]]) -> NDArray[np.void]:
    try:
        return _table(lines)
    except OSError as error:
        raise InputError(f"{path} cannot be read: {error.strerror or error}.") from None
    except (ValueError, TypeError, OverflowError, csv.Error) as error:
        raise InputError(
            f"{path} is not a file of tracks ({error}); give one that motes track or watch wrote."
        ) from None


def _parquet_rows(path: str | Path) -> Iterator[Sequence[Any]]:
    """Yield the names of the columns, then the values of each row."""
    parquet = optional("pyarrow.parquet", "Parquet needs pyarrow", "motes[parquet]")
    with parquet.ParquetFile(path) as file:
        yield file.schema_arrow.names
        for batch in file.iter_batches():
            yield from zip(*(column.to_pylist() for column in batch.columns), strict=True)


def _csv_lines(text: str) -> Iterator[Sequence[Any]]:
    if "\r" in text and "\n" not in text:
        raise ValueError(OLD_LINES)
    lines = csv.reader(io.StringIO(text), strict=True, skipinitialspace=True)
    yield [title.strip() for title in next(lines, ())]
    for row in lines:
        yield [unguarded(field) for field in row]
    check_ended(text)


def _json_lines(text: str) -> Iterator[Sequence[Any]]:
    """Yield the keys of the first row, then the values of each row."""
    names: list[str] | None = None
    for number, line in enumerate(lines_of(text) if text else (), start=1):
        try:
            row = msgspec.json.decode(line, type=dict[str, int | float | str | None])
        except (msgspec.MsgspecError, RecursionError) as error:
            raise ValueError(f"line {number}: {error}") from None
        if names is None:
            names = list(row)
            yield names
        if list(row) != names:
            raise ValueError(f"line {number} has other keys than the first line")
        yield list(row.values())


def _table(lines: Iterator[Sequence[Any]]) -> NDArray[np.void]:
    names = list(next(lines, ()))
    if names[:1] == [""]:
        raise ValueError(
            "its first column has no title, as row names of R and the index of pandas; write it "
            "with row.names=FALSE or index=False"
        )
    for mark in ";\t":
        if len(names) == 1 and mark in names[0]:
            raise ValueError(SEPARATED.format(mark))
    others = [name for name in names if name not in TYPES]
    if "frame" in names and others:
        named = ", ".join(others)[:80]
        raise ValueError(f"rows have no column {named}: rename it, or remove it from a copy")
    if "frame" not in names or len(set(names)) < len(names):
        raise ValueError(f"its columns are {', '.join(names)[:80] or 'missing'}")
    rows = []
    for number, row in enumerate(lines, start=1):
        if len(row) != len(names):
            raise ValueError(f"row {number} has {len(row)} fields instead of {len(names)}")
        rows.append(row)
    columns: dict[str, NDArray[Any]] = {
        name: np.array(_values(name, [row[i] for row in rows]), TYPES[name])
        for i, name in enumerate(names)
    }
    table = np.empty(len(rows), [(name, column.dtype) for name, column in columns.items()])
    for name, column in columns.items():
        table[name] = column
    return table


def _values(name: str, fields: Sequence[str | float | None]) -> list[str | float]:
    """Return the fields of a column as values of its type."""
    value = _number if name in NUMBERS else _whole if name in WHOLE else _text
    found: list[str | float] = []
    try:
        for field in fields:
            found.append(value(field))
    except ValueError as error:
        raise ValueError(f"row {len(found) + 1}: {name}: {error}") from None
    return found


def _number(field: str | float | None) -> float:
    if field is None or field == "":
        return math.nan
    try:
        return float(field.replace("_", "?") if isinstance(field, str) else field)
    except ValueError:
        raise ValueError(f"{field[:20]!r} is not a number") from None  # type: ignore[index]


def _whole(field: str | float | None) -> int:
    """Return a whole number, which other programs write as 7.0 or 1e+05 too."""
    value = _number(field)
    if not (value.is_integer() and abs(value) < 1 << 63):
        raise ValueError(f"{str(field)[:20]!r} is no whole number, or too large")
    try:
        return int(field)  # type: ignore[arg-type]
    except ValueError:
        return int(value)


def _text(field: str | float | None) -> str:
    if isinstance(field, float | int):
        raise ValueError(f"{field} is no text")
    return check_label(field) if field else ""
