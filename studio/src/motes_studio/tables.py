"""Tracks of many frames as one array: what workers send, the store keeps and sessions show."""

from __future__ import annotations

import hashlib
import math
from collections.abc import Collection, Iterable, Sequence

import numpy as np

from motes import Ellipse, Status, Track
from motes.core import Floats
from motes_studio.messages import Row

STATUSES = tuple(Status)
"""A status is stored as its place here."""
FRAME, TIME, ELLIPSE, VARIANCES = 0, 1, slice(2, 7), slice(7, 12)
CONFIDENCE, STATUS, DISTANCE, SIZE, BELIEF, OUTLIER, FINAL = 12, 13, 14, 15, 16, 17, 18
MILLISECONDS, SUPPORTING, CUES = 19, 20, 21
"""The columns; those from `CUES` on are the cue weights. `SIZE` is the effective sample size."""

Table = Floats
"""(n, CUES + number of cues), a row for each frame."""


def line(
    track: Track,
    cue_weights: Sequence[float],
    *,
    final: bool,
    milliseconds: float = math.nan,
    supporting: float | None = None,
) -> list[float]:
    """Return the row of a track."""
    return [
        track.frame, track.time, *track.ellipse, *track.covariance.diagonal().tolist(),
        track.confidence, STATUSES.index(track.status), track.distance,
        track.effective_sample_size, track.belief, track.outlier, final, milliseconds,
        math.nan if supporting is None else supporting, *cue_weights,
    ]  # fmt: skip


def pack(table: Table) -> bytes:
    """Return a table as bytes, without its width."""
    return np.ascontiguousarray(table, np.float64).tobytes()


def digest(table: Table) -> str:
    """Return a short name of a table, which equal ones have in common."""
    return hashlib.blake2b(pack(table), digest_size=16).hexdigest()


def unpack(data: bytes, cues: int) -> Table:
    """Return the table of `pack`, given the number of cues."""
    return np.frombuffer(data, np.float64).reshape(-1, CUES + cues)


def tracks(table: Table) -> list[Track]:
    """Return rows as tracks."""
    return [
        Track(
            frame=int(row[FRAME]), time=row[TIME], ellipse=Ellipse(*row[ELLIPSE]),
            covariance=np.diag(row[VARIANCES]), confidence=row[CONFIDENCE],
            status=STATUSES[int(row[STATUS])], distance=row[DISTANCE],
            effective_sample_size=row[SIZE], belief=row[BELIEF], outlier=bool(row[OUTLIER]),
        )
        for row in table.tolist()
    ]  # fmt: skip


def without(table: Table, absent: Collection[int]) -> Table:
    """Return rows in which the object is absent in some frames, where it has no place then."""
    table = table.copy()
    there = np.isin(table[:, FRAME], [*absent])
    table[there, ELLIPSE.start : VARIANCES.stop] = table[there, CONFIDENCE] = math.nan
    table[there, STATUS] = STATUSES.index(Status.ABSENT)
    return table


def rows(table: Table) -> list[Row]:
    """Return rows for the page; NaN is None."""
    found = []
    for row in table.tolist():
        values = [value if math.isfinite(value) else None for value in row]
        x, y, a, b, theta = values[ELLIPSE]
        deviations = tuple(math.sqrt(max(value, 0.0)) for value in row[VARIANCES])
        found.append(
            Row(
                frame=int(row[FRAME]), time=row[TIME], x=x, y=y, a=a, b=b, theta=theta,
                confidence=values[CONFIDENCE], status=str(STATUSES[int(row[STATUS])]),
                distance=values[DISTANCE], effective_sample_size=values[SIZE],
                belief=values[BELIEF],
                deviations=deviations if all(map(math.isfinite, deviations)) else None,
                cue_weights=tuple(value if math.isfinite(value) else 0.0 for value in row[CUES:]),
                final=bool(row[FINAL]), milliseconds=values[MILLISECONDS],
                supporting=values[SUPPORTING],
            )
        )  # fmt: skip
    return found


def table_of(lines: Iterable[Sequence[float]], cues: int) -> Table:
    """Return rows of `line` as a table."""
    return np.array([*lines], np.float64).reshape(-1, CUES + cues)
