"""Rows of motes in Apache Parquet, with the columns of `rows`; it needs pyarrow."""

from __future__ import annotations

import contextlib
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from motes.core.callables import optional
from motes.core.errors import FormatError
from motes.formats.recording import FilmFacts, Recording
from motes.formats.rows import recording_of_rows, table_of
from motes.rows.schema import KNOWN, TEXT, WHOLE

BATCH = 1 << 14
"""Rows that are unpacked at a time."""
LONGEST = 1000
"""Characters of a text: a few that are long may be in all rows of a small file."""
VALUE = 8
"""Bytes of a value."""


def _pyarrow() -> Any:
    optional("pyarrow.parquet", "Parquet needs pyarrow", "motes[parquet]")
    import pyarrow

    return pyarrow


def write(recorded: Recording) -> Iterator[bytes]:
    """Yield a table with a row for each object in each frame; empty fields are null."""
    pyarrow = _pyarrow()
    names, rows = table_of(recorded)
    columns = list(zip(*rows, strict=True)) or [()] * len(names)
    kinds = dict.fromkeys((*WHOLE, "occluded_by", "outlier"), pyarrow.int64())
    kinds |= dict.fromkeys(TEXT, pyarrow.string())
    arrays = [
        pyarrow.array(values, kinds.get(name, pyarrow.float64()), from_pandas=True)  # NaN is null
        for name, values in zip(names, columns, strict=True)
    ]
    sink = pyarrow.BufferOutputStream()
    pyarrow.parquet.write_table(pyarrow.table(dict(zip(names, arrays, strict=True))), sink)
    yield sink.getvalue().to_pybytes()


def read(path: Path, facts: FilmFacts) -> Recording:
    """Return the objects of a table that `write` made."""
    nested = _pyarrow().types.is_nested
    with _opened(path) as file:
        names = file.schema_arrow.names
        if "frame" not in names:
            raise FormatError(f"its columns are {', '.join(names)[:200]}; it needs one frame")
        for field in file.schema_arrow:
            if nested(field.type):
                raise FormatError(f"its column {field.name[:80]} holds lists; leave it out")
        known = [name for name in names if name in KNOWN]
        batches = file.iter_batches(BATCH, columns=known)
        cells = (row for batch in batches for row in zip(*batch.columns, strict=True))
        rows = (dict(zip(known, map(_value, row), strict=True)) for row in cells)
        return recording_of_rows(rows, names, facts)


def _value(cell: Any) -> Any:
    value = cell.as_py()
    if isinstance(value, str) and len(value) > LONGEST:
        raise FormatError(f"it has a text of {len(value):,} characters; shorten it")
    return value


def size(path: Path) -> int:
    """Return how many bytes the values of a table have, of which its file may have few.

    Raises a FormatError if it is no table.
    """
    with _opened(path) as file:
        about = file.metadata
        groups = [about.row_group(i).total_byte_size for i in range(about.num_row_groups)]
        found: int = max(sum(groups), VALUE * about.num_rows * about.num_columns)
        return found


@contextlib.contextmanager
def _opened(path: Path) -> Iterator[Any]:
    """Open a table, of which nothing but its metadata is read at first."""
    pyarrow = _pyarrow()
    try:
        with pyarrow.parquet.ParquetFile(path) as file:
            yield file
    except MemoryError:  # which is one of Arrow's too
        raise
    except (pyarrow.ArrowException, OSError) as error:
        if getattr(error, "errno", None):
            raise
        raise FormatError(f"it is not a table of Parquet: {error}") from None
