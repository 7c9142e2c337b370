"""Published results, for comparison with those of this run."""

from __future__ import annotations

import csv
import io
from dataclasses import dataclass
from pathlib import Path
from typing import Self

from motes.core.errors import FormatError, SourceError


@dataclass(frozen=True, slots=True, eq=False)
class Reference:
    """Published results: the success AUC of trackers on sequences.

    Attributes
    ----------
    name
        Name of the file.
    values
        By tracker, then by sequence in lower case.
    """

    name: str
    values: dict[str, dict[str, float]]

    def of(self, tracker: str, sequence: str) -> float | None:
        """Return the AUC of a tracker on a sequence, ignoring its case; None if there is none."""
        return self.values[tracker].get(sequence.casefold())

    @classmethod
    def load(cls, path: str | Path) -> Self:
        """Read a CSV file with a row for each sequence.

        The first column names the sequence. A column NAME_AUC holds the numbers of a tracker NAME;
        if there is no such column, all columns are used under their own names. Numbers are from 0
        to 1 and may be missing. Columns are separated by commas, semicolons or tabs.

        Raises
        ------
        SourceError
            If the file cannot be read.
        FormatError
            If it has another format.
        """
        path = Path(path)
        try:
            text = path.read_text(encoding="utf-8-sig")
        except OSError as error:
            raise SourceError(f"The reference {path} cannot be read: {error.strerror}.") from None
        except UnicodeDecodeError:
            raise FormatError(f"The reference {path} is not text; save it as UTF-8.") from None
        try:
            return cls(path.name, _reference(text))
        except (ValueError, csv.Error) as error:
            raise FormatError(f"The reference {path}: {error}.") from None


def _reference(text: str) -> dict[str, dict[str, float]]:
    head = text.partition("\n")[0]
    rows = csv.reader(io.StringIO(text), delimiter=max(",;\t", key=head.count))
    columns = [name.strip() for name in next(rows, [])]
    if len(columns) < 2:
        raise ValueError("its first line must name at least two columns, as in sequence,MIL_AUC")
    chosen = [i for i, name in enumerate(columns) if i and name.endswith("_AUC")]
    names = {i: columns[i].removesuffix("_AUC") for i in chosen or range(1, len(columns))}
    if "" in names.values() or len(set(names.values())) < len(names):
        raise ValueError("its first line must give each column a different name")
    values: dict[str, dict[str, float]] = {name: {} for name in names.values()}
    seen: set[str] = set()
    for row in rows:
        if not any(row):
            continue
        where = f"line {rows.line_num}"
        if len(row) != len(columns):
            raise ValueError(f"{where} has {len(row)} columns, the first line has {len(columns)}")
        sequence = row[0].strip().casefold()
        if not sequence or sequence in seen:
            raise ValueError(f"{where} must name another sequence, not {row[0].strip()!r}")
        seen.add(sequence)
        for i, name in names.items():
            field = row[i].strip()
            if field and field.lower() != "nan":
                values[name][sequence] = _auc(field, f"{where}, column {columns[i]}")
    if not seen:
        raise ValueError("there is no sequence after its first line")
    return values


def _auc(field: str, where: str) -> float:
    try:
        value = float(field)
    except ValueError:
        raise ValueError(f"{where}: {field[:20]!r} is not a number") from None
    if not 0 <= value <= 1:
        raise ValueError(f"{where}: an AUC is from 0 to 1, not {value:g}")
    return value
