"""The scores of an evaluation that was run before, read from its results.csv."""

from __future__ import annotations

import csv
import io
import math
from dataclasses import dataclass
from pathlib import Path
from typing import Self

import numpy as np

from motes.core.errors import FormatError, SourceError
from motes_lab.aggregate import ranking_column
from motes_lab.datasets.sot import printable

PASS = "tracker", "sequence", "protocol", "start", "seed"
"""The columns that name a pass."""


@dataclass(frozen=True, eq=False)
class SavedScores:
    """A number for each tracker on each sequence, the mean over starts and seeds.

    Attributes
    ----------
    name
        The folder.
    protocol, column
        The protocol, and the column of results.csv.
    values
        By tracker, then by sequence; only sequences without a failed pass.
    """

    name: str
    protocol: str
    column: str
    values: dict[str, dict[str, float]]

    @classmethod
    def load(cls, folder: Path, protocol: str | None = None, column: str | None = None) -> Self:
        """Read the scores of a protocol, by default of the first one in the file.

        The default column is the one by which the protocol ranks trackers.

        Raises
        ------
        SourceError
            If there is no results.csv, or it has no pass in this protocol, or no such column.
        FormatError
            If it is not one that `motes-lab evaluate` wrote.
        """
        path = folder / "results.csv"
        try:
            text = path.read_text(encoding="utf-8-sig")
        except OSError as error:
            raise SourceError(
                f"{path} cannot be read: {error.strerror}; give the folder of an evaluation."
            ) from None
        except UnicodeDecodeError:
            raise FormatError(
                f"{path} is not text; make it again with motes-lab evaluate."
            ) from None
        try:
            rows = _rows(text)
            protocols = dict.fromkeys(row["protocol"] for row in rows)
            used = protocol or next(iter(protocols), "ope")
            wanted = column or ranking_column(used)
            values = _means([row for row in rows if row["protocol"] == used], wanted)
        except (csv.Error, KeyError, TypeError, ValueError):
            raise FormatError(
                f"{path} is not a table of motes-lab evaluate, or is damaged; make it again with "
                f"--resume."
            ) from None
        if used not in protocols:
            known = ", ".join(protocols) or "none"
            raise SourceError(f"{path} has no pass of the protocol {used}; it has {known}.")
        if not values:
            raise SourceError(f"{path} has no number in the column {wanted}.")
        return cls(printable(str(folder)), used, wanted, values)


def _rows(text: str) -> list[dict[str, str]]:
    """Return the passes of a results.csv; raise a ValueError if it is cut off or damaged."""
    rows = list(csv.DictReader(io.StringIO(text), strict=True))
    if not text.endswith("\n") and rows:
        raise ValueError("cut off")
    if any(None in row or None in row.values() for row in rows):
        raise ValueError("fields")
    passes = {tuple(row[name] for name in PASS) for row in rows}
    if len(passes) < len(rows):
        raise ValueError("a pass twice")
    return rows


def _means(rows: list[dict[str, str]], column: str) -> dict[str, dict[str, float]]:
    """Return the mean over starts of each seed, and over seeds, by tracker and sequence."""
    found: dict[tuple[str, str], dict[str, list[float]]] = {}
    failed: set[tuple[str, str]] = set()
    for row in rows:
        key = row["tracker"], row["sequence"]
        if row["error"]:
            failed.add(key)
        elif row[column]:
            if not math.isfinite(number := float(row[column])):
                raise ValueError(column)
            found.setdefault(key, {}).setdefault(row["seed"], []).append(number)
    values: dict[str, dict[str, float]] = {}
    for (tracker, sequence), seeds in found.items():
        if (tracker, sequence) not in failed:
            mean = float(np.mean([np.mean(starts) for starts in seeds.values()]))
            values.setdefault(tracker, {})[sequence] = mean
    return values
