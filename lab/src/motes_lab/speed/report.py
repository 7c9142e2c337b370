"""Tables of measured speeds, and their comparison with stored ones."""

from __future__ import annotations

import contextlib
import math
import statistics
from collections.abc import Mapping, Sequence
from pathlib import Path

from motes import SourceError
from motes_lab.adapters.opencv import PEERS
from motes_lab.report.tables import NO_VALUE, Cell, Row, Table, number, three_digits
from motes_lab.speed.measure import FOLLOWERS, MAIN, REFERENCE, SIZE, Job

RATIOS = ("cv2:mosse", "cv2:csrt")
"""The fastest and the most accurate of OpenCV's trackers.

Ratios to their times in the same run can be compared with those of another day or another machine.
"""
MAX_SLOWDOWN = 0.15
"""A ratio that has grown by more than this share is marked."""
TIMES = "times "
"""The start of the title of a column of ratios; the name of the reference follows."""

Ratio = tuple[str, str, str]
"""Tracker, target and peer."""


def trackers_table(seconds: Mapping[Job, list[float]], note: str) -> Table:
    """Return a table of each tracker's time of an update, and its ratios to others."""
    medians = {job: statistics.median(times) for job, times in seconds.items()}
    others = [name for name in (REFERENCE, *RATIOS) if (name, MAIN) in medians]
    rows: list[Row] = []
    for job, times in seconds.items():
        high = statistics.quantiles(times, n=20)[-1]
        milliseconds = (number(1e3 * value) for value in (medians[job], high))
        ratios = (three_digits(medians[job] / medians[name, MAIN]) for name in others)
        rows.append((Cell(job[0]), Cell(named_size(job[1])), *milliseconds, *ratios))
    head = ("tracker", "target", "median ms", "95 % ms", *(TIMES + name for name in others))
    note = f"Ratios are to the other one's median on the {named_size(MAIN)} target. {note}"
    return Table(f"One update, {named_size(SIZE)}, one core", head, rows, note=note.strip())


def sequences_table(seconds: Mapping[tuple[str, str], list[float]], note: str) -> Table:
    """Return the time of an update of each tracker on real sequences, by sequence and tracker.

    Below are the ratios of each tracker to those of motes: geometric means over the sequences on
    which it ran.
    """
    seconds = {key: times for key, times in seconds.items() if len(times) > 1}
    medians = {key: statistics.median(times) for key, times in seconds.items()}
    films, trackers = (dict.fromkeys(names) for names in zip(*medians, strict=True))

    def ratios(film: str, tracker: str) -> list[float]:
        return [medians[film, tracker] / medians[film, name] for name in FOLLOWERS]

    rows: list[Row] = []
    for (film, tracker), times in seconds.items():
        high = statistics.quantiles(times, n=20)[-1]
        milliseconds = (number(1e3 * value) for value in (medians[film, tracker], high))
        cells = map(three_digits, ratios(film, tracker))
        rows.append((Cell(film), Cell(shown(tracker)), *milliseconds, *cells))
    feet: list[Row] = []
    for tracker in trackers:
        each = zip(
            *(ratios(film, tracker) for film in films if (film, tracker) in medians), strict=True
        )
        means = (three_digits(statistics.geometric_mean(values)) for values in each)
        feet.append((Cell("all"), Cell(shown(tracker)), Cell(""), Cell(""), *means))
    head = ("sequence", "tracker", "median ms", "95 % ms", *(TIMES + name for name in FOLLOWERS))
    text = "Frames are decoded right before each update, and BGR; all are geometric means."
    return Table(
        "One update on real sequences, one core", head, rows, (*feet,), f"{text} {note}".strip()
    )


def shown(tracker: str) -> str:
    """Return the name of a tracker without the files that belong to it."""
    return tracker.partition("=")[0]


def stored_ratios(text: str, where: Path) -> dict[Ratio, float]:
    """Return the ratios in the table of trackers of a Markdown file.

    Raises
    ------
    SourceError
        If there is no such table.
    """
    tables: list[list[list[str]]] = [[]]
    for line in text.splitlines():
        if line.startswith("|"):
            tables[-1].append([cell.strip() for cell in line.strip().strip("|").split("|")])
        else:
            tables.append([])
    for table in filter(None, tables):
        if found := _ratios(table):
            return found
    raise SourceError(f"{where} holds no table of trackers such as motes-lab bench --out writes.")


def _ratios(lines: Sequence[Sequence[str]]) -> dict[Ratio, float]:
    """Return the ratios of motes to its peers in a table's lines; the first is the head."""
    found: dict[Ratio, float] = {}
    head, *rows = lines
    for row in rows:
        for title, cell in zip(head, row, strict=False):
            peer = title.removeprefix(TIMES)
            if peer in PEERS and row[0] not in PEERS:
                with contextlib.suppress(ValueError):  # the line under the head, and empty cells
                    if 0 < (ratio := float(cell)) < math.inf:
                        found[row[0], row[1], peer] = ratio
    return found


def against(table: Table, stored: Mapping[Ratio, float]) -> Table:
    """Return the ratios in a table of trackers beside stored ones; slower ones are marked."""
    found = _ratios([table.head, *([cell.text for cell in row] for row in table.rows)])
    rows: list[Row] = []
    slower = 0
    for ratio, now in found.items():
        before, change, mark = Cell(NO_VALUE), Cell(NO_VALUE), ""
        if ratio in stored:
            grown = now / stored[ratio] - 1
            before, change = three_digits(stored[ratio]), Cell(f"{grown:+.0%}", grown)
            if grown > MAX_SLOWDOWN:
                slower, mark = slower + 1, "slower"
        rows.append((*map(Cell, ratio), three_digits(now), before, change, Cell(mark)))
    head = ("tracker", "target", "peer", "ratio", "stored", "change", "")
    note = f"{slower} of {len(rows)} are more than {MAX_SLOWDOWN:.0%} slower against their peer."
    return Table("Ratios to peers in the same run, now and as stored", head, rows, note=note)


def named_size(target: tuple[int, int]) -> str:
    """Return width and height as text, such as 640x480."""
    return f"{target[0]}x{target[1]}"
