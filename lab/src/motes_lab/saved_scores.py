"""The scores of an evaluation that was run before, read from its results.csv."""

from __future__ import annotations

import csv
import io
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Self

import numpy as np
import pandas as pd

from motes import ConfigError, FormatError, SourceError
from motes_lab.aggregate import ranking_column
from motes_lab.datasets.sot import printable
from motes_lab.mot_scores import COMBINED

PASS = ["tracker", "sequence", "protocol", "start", "seed"]
"""The columns that name a pass."""


@dataclass(frozen=True, eq=False)
class SavedScores:
    """A number for each tracker on each sequence, the mean over starts, then over seeds."""

    name: str
    """The folder."""
    protocol: str
    column: str
    """The protocol, and the column of results.csv."""
    values: pd.DataFrame
    """(sequences, trackers); NaN where a pass failed, or none has a number."""

    @classmethod
    def load(cls, folder: Path, protocol: str | None = None, column: str | None = None) -> Self:
        """Read the scores of a protocol, by default of the first one in the file.

        The default column is the one by which the protocol ranks trackers.

        Raises
        ------
        SourceError
            If there is no results.csv, or it has no pass in this protocol, or no number in the
            column.
        ConfigError
            If there is no such column of numbers.
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
            known = [name for name in rows if name not in (*PASS, "error")]
            if column is not None and column not in known:
                raise ConfigError(
                    f"{path} has no numbers {column}; choose one of {', '.join(known)}."
                )
            protocols = rows["protocol"].unique()
            used = protocol or next(iter(protocols), "ope")
            wanted = column or ranking_column(used)
            values = _means(rows[rows["protocol"] == used], wanted)
        except ConfigError:  # which is a ValueError too
            raise
        except (csv.Error, KeyError, TypeError, ValueError):
            raise FormatError(
                f"{path} is not a table of motes-lab evaluate, or is damaged; make it again with "
                f"--resume."
            ) from None
        if used not in protocols:
            there = ", ".join(protocols) or "none"
            raise SourceError(f"{path} has no pass of the protocol {used}; it has {there}.")
        if not values.size:
            raise SourceError(f"{path} has no number in the column {wanted}.")
        return cls(printable(str(folder)), used, wanted, values)


def _rows(text: str) -> Any:
    """Return the passes of a results.csv; raise a ValueError if it is cut off or damaged."""
    reader = csv.DictReader(io.StringIO(text), strict=True)
    rows = list(reader)
    if not text.endswith("\n") and rows:
        raise ValueError("cut off")
    if any(None in row or None in row.values() for row in rows):
        raise ValueError("fields")
    passes = pd.DataFrame(rows, columns=reader.fieldnames)
    if passes.duplicated(PASS).any():
        raise ValueError("a pass twice")
    return passes[(passes["protocol"] != "mot") | (passes["sequence"] != COMBINED)]


def _means(rows: Any, column: str) -> Any:
    """Return the means over the starts of each seed, and over seeds, (sequences, trackers)."""
    given = rows[rows[column] != ""]
    numbers = given[column].astype(float)
    if not np.isfinite(numbers).all():
        raise ValueError(column)
    keys = ["sequence", "tracker"]
    means = numbers.groupby([given[key] for key in (*keys, "seed")]).mean().groupby(keys).mean()
    failed = rows.loc[rows["error"] != "", keys].itertuples(index=False, name=None)
    table = means.drop(list(failed), errors="ignore").unstack()
    sequences = [name for name in rows["sequence"].unique() if name in set(given["sequence"])]
    return table.reindex(index=sequences, columns=rows["tracker"].unique())
