"""Tables of jobs: CSV, JSON Lines, Parquet, TOML, or a pattern of films; read row by row."""

from __future__ import annotations

import csv
import glob
import json
import os
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from motes import ConfigError, MotesError, SourceError
from motes.core import from_toml, optional
from motes.rows import text_name
from motes_fleet.cluster.inputs import stamp
from motes_fleet.cluster.jobs import Job, noted, read_job

Row = tuple[int, Mapping[str, Any]]
SHOWN = 50
"""Problems of a table that are listed; the others are counted."""


@dataclass(frozen=True)
class JobTable:
    """The rows of a table, which can be read several times; few of them are in memory."""

    name: str
    """A file .csv, .jsonl, .parquet or .toml, or a pattern of films."""
    defaults: Mapping[str, Any] = field(default_factory=dict)
    """Values of columns that a row leaves empty."""

    def rows(self) -> Iterator[Row]:
        """Yield the number of each row, as an editor shows it, and its columns.

        Raises
        ------
        SourceError
            If the table cannot be read.
        """
        reader = READERS.get(os.path.splitext(self.name)[1].lower())
        try:
            if glob.has_magic(self.name) or reader is None:
                yield from _films(self.name)
            else:
                yield from reader(Path(self.name))
        except OSError as error:
            raise SourceError(f"{self.name} cannot be read: {error.strerror or error}.") from None
        except RecursionError:
            raise SourceError(f"{self.name} is nested too deeply; a row has values only.") from None
        except (UnicodeDecodeError, csv.Error, ValueError) as error:
            if isinstance(error, MotesError):
                raise
            raise SourceError(f"{self.name} cannot be read as a table: {error}.") from None

    def jobs(self) -> Iterator[Job]:
        """Yield the jobs of a table that was checked."""
        for _, row in self.rows():
            job, wrong = read_job(*self._columns(row))
            if job is None:
                raise ConfigError(" ".join(wrong))
            yield job

    def _columns(self, row: Mapping[str, Any]) -> tuple[Mapping[str, Any], str]:
        """Return the columns of a row with the defaults, and the name of a job without one."""
        given = {key: value for key, value in row.items() if value not in (None, "")}
        source = Path(str(given.get("source", "")))
        named = source.parent.name if glob.has_magic(source.name) else source.stem
        return {**self.defaults, **given}, named

    def problems(self, check: Callable[[Job], None]) -> tuple[int, int, list[str]]:
        """Return the number of jobs, of those with problems, and the first problems.

        Each has its rows; one that several rows have is there once. `check` raises a MotesError for
        a job that cannot be used.
        """
        names: dict[str, int] = {}
        found: dict[str, list[int]] = {}
        jobs = count = 0
        for number, row in self.rows():
            jobs += 1
            job, wrong = read_job(*self._columns(row))
            if job is not None:
                if (other := names.setdefault(job.name, number)) != number:
                    wrong.append(
                        f"row {other} has the name {job.name!r} too; rename its film, or give a "
                        f"table with names."
                    )
                with noted(wrong):
                    wrong += _wrong_files(job)
                    if not wrong:
                        check(job)
            count += bool(wrong)
            for text in wrong:
                if text in found or len(found) < SHOWN:
                    found.setdefault(text, []).append(number)
        return jobs, count, [f"{self.name}, {_rows(rows)}: {text}" for text, rows in found.items()]


def _wrong_files(job: Job) -> Iterator[str]:
    """Yield what is wrong with the names of a job's files."""
    for column, path in job.files:
        if path and not stamp(path):
            yield f"the {column} {path} is missing; check the name."
        elif text_name(path) != path:  # the list of jobs could not hold it
            yield f"the name {path} has bytes that are no text; rename the file."


def _rows(numbers: list[int]) -> str:
    """Return some rows by their numbers: three of them, and how many more there are."""
    if len(numbers) == 1:
        return f"row {numbers[0]}"
    named = [str(number) for number in numbers[:3]]
    if more := len(numbers) - len(named):
        named.append(f"{more} more")
    return f"rows {', '.join(named[:-1])} and {named[-1]}"


def _csv(path: Path) -> Iterator[Row]:
    with path.open(newline="", encoding="utf-8-sig") as file:
        reader = csv.DictReader(file)
        if ";" in "".join(reader.fieldnames or ()):
            raise ValueError("it has semicolons between its columns; save it with commas")
        for row in reader:
            if None in row:
                raise ValueError(
                    f"row {reader.line_num} has more fields than the first row; "
                    'a box needs quotes: "300,200,40,60"'
                )
            yield reader.line_num, row


def _json_lines(path: Path) -> Iterator[Row]:
    with path.open(encoding="utf-8-sig") as file:
        for number, line in enumerate(file, 1):
            if line.strip():
                row = json.loads(line)
                if not isinstance(row, dict):
                    raise ValueError(f"line {number} is no object")
                yield number, row


def _parquet(path: Path) -> Iterator[Row]:
    parquet = optional("pyarrow.parquet", "Parquet needs pyarrow", "motes[parquet]")
    number = 0
    with parquet.ParquetFile(path) as file:
        for batch in file.iter_batches(1000):
            for row in batch.to_pylist():
                number += 1
                yield number, row


def _toml(path: Path) -> Iterator[Row]:
    table = from_toml(path.read_text(encoding="utf-8-sig"), path.name)
    rows = table.pop("job", [])
    if table or not isinstance(rows, list):
        raise ValueError("a table of jobs has [[job]] only")
    yield from enumerate(rows, 1)


def _films(pattern: str) -> Iterator[Row]:
    """Yield the files of a pattern; their names begin where the pattern does."""
    found = sorted(glob.glob(pattern, recursive=True))
    if not found:
        raise SourceError(
            f"{pattern} is no table (.csv, .jsonl, .parquet, .toml) and fits no film; check it."
        )
    fixed = pattern[: min((pattern.find(mark) for mark in "*?[" if mark in pattern), default=0)]
    root = os.path.dirname(fixed) or "."
    for number, path in enumerate(found, 1):
        name = os.path.relpath(path, root) if glob.has_magic(pattern) else os.path.basename(path)
        yield number, {"source": path, "name": os.path.splitext(name)[0]}


READERS: dict[str, Callable[[Path], Iterator[Row]]] = {
    ".csv": _csv,
    ".jsonl": _json_lines,
    ".parquet": _parquet,
    ".toml": _toml,
}
"""The forms of tables, by the ending of their names."""
