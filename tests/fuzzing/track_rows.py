"""Rows of `motes track` that are resumed: CSV, or JSON Lines if they begin with a brace."""

from functools import cache
from pathlib import Path

import numpy as np

from motes import Ellipse, Status, Track, TrackWriter

from .outcomes import REFUSED, DefectError, outcome, put, scratch

FRAMES = 12


def seeds() -> list[bytes]:
    whole = [_whole("rows.csv"), _whole("rows.jsonl")]
    return [*whole, *(rows[: len(rows) // 2] for rows in whole)]


def check(data: bytes) -> str:
    """Resume the rows: they become whole, or are refused and stay as they are."""
    path = put("rows.jsonl" if data.startswith(b"{") else "rows.csv", data)
    found = outcome(lambda: _write(path))
    expected = data if found == REFUSED else _whole(path.name)
    if path.read_bytes() != expected:
        raise DefectError(f"The rows were {found}, but are not as they must be.")
    return found


@cache
def _whole(name: str) -> bytes:
    path = scratch() / "whole" / name
    path.parent.mkdir(exist_ok=True)
    _write(path)
    return path.read_bytes()


def _write(path: Path) -> None:
    with TrackWriter(path, resume=True) as writer:
        for index in range(FRAMES):
            writer.write(index, index / 25, _track(index))


def _track(index: int) -> Track | None:
    if not index:
        return None
    ellipse = Ellipse(20 + 1.5 * index, 30 - index, 8, 5 + 0.1 * index, 0.01 * index)
    return Track(index, index / 25, ellipse, np.eye(5), 0.9, Status.TRACKING, 0.1, 80.0)
