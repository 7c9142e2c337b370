"""Rows of motes in Apache Parquet, with the columns of `rows`; it needs pyarrow."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

from motes.core.errors import FormatError
from motes.core.optional import optional
from motes.formats.recording import FilmFacts, Recording
from motes.formats.rows import recording_of_rows, table_of
from motes.rows.schema import TEXT, WHOLE


def _pyarrow() -> Any:
    optional("pyarrow.parquet", "Parquet needs pyarrow", "motes[parquet]")
    import pyarrow

    return pyarrow


def write(recorded: Recording) -> Iterator[bytes]:
    """Yield a table with a row for each object in each frame; empty fields are null."""
    pyarrow = _pyarrow()
    names, rows = table_of(recorded)
    columns = list(zip(*rows, strict=True)) or [()] * len(names)
    kinds = {int: pyarrow.int64(), float: pyarrow.float64(), str: pyarrow.string()}
    arrays = [
        pyarrow.array(values, kinds[_kind(name)], from_pandas=True)  # NaN is null
        for name, values in zip(names, columns, strict=True)
    ]
    sink = pyarrow.BufferOutputStream()
    pyarrow.parquet.write_table(pyarrow.table(dict(zip(names, arrays, strict=True))), sink)
    yield sink.getvalue().to_pybytes()


def _kind(name: str) -> type:
    return int if name in (*WHOLE, "occluded_by") else str if name in TEXT else float


def read(path: Path, facts: FilmFacts) -> Recording:
    """Return the objects of a table that `write` made."""
    pyarrow = _pyarrow()
    try:
        table = pyarrow.parquet.read_table(path)
    except (pyarrow.ArrowException, ValueError) as error:
        raise FormatError(f"it is not a table of Parquet: {error}") from None
    if "frame" not in table.column_names:
        raise FormatError(f"its columns are {', '.join(table.column_names)}; it needs one frame")
    return recording_of_rows(iter(table.to_pylist()), table.column_names, facts)
