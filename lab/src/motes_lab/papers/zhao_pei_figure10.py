"""Zhao and Pei, figure 10: objects that are detected, tracked and counted, on films.

The truth is found by eye: frames in which lines are crossed.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Annotated, NamedTuple

import numpy as np
from msgspec import Meta

from motes import Config, Event, EventCounter, Line, Regions, Scene, named_detector, open_source
from motes.mot import assign
from motes_lab.experiment import Experiment, Result, ResultOptions
from motes_lab.report.tables import Cell, Row, Table, number

HEAD = ("film and line", "true", "counted", "missed", "false", "frames missed", "frames false")
Frame = Annotated[int, Meta(ge=0)]


class CrossedLine(Config, frozen=True):
    """A line, and the frames in which it is crossed."""

    points: tuple[float, float, float, float]
    """Its two ends: x1, y1, x2, y2, in pixels."""
    left: tuple[Frame, ...] = ()
    right: tuple[Frame, ...] = ()
    """The frames of the crossings to each side, as seen from the first point towards the second."""


class CountedClip(Config, frozen=True):
    """A film with lines whose crossings are known."""

    file: str
    """Its name in the folder of films."""
    line: Annotated[tuple[CrossedLine, ...], Meta(min_length=1)]
    """The lines."""


class CountedClips(Config, frozen=True):
    """Films with known crossings. In TOML: [[clip]] with [[clip.line]]."""

    clip: Annotated[tuple[CountedClip, ...], Meta(min_length=1)]
    """The films."""


def zhao_figure10(truth: Path, films: Path, /, *, results: ResultOptions = ResultOptions()) -> int:
    """Zhao and Pei, figure 10: objects that cross lines, counted.

    Parameters
    ----------
    truth
        A TOML file of true crossings: [[clip]] with file, and [[clip.line]] with points, left and
        right, the frames of the crossings to each side.
    films
        The folder of the films.
    """
    return results.show("zhao-figure10", figure10(CountedClips.load(truth), films))


WITHIN = 10
"""Frames by which a counted crossing may be early or late."""


class Compared(NamedTuple):
    """Frames of true crossings that were counted and missed, and of false ones, each sorted."""

    counted: list[int]
    missed: list[int]
    false: list[int]

    def __add__(self, other: tuple[list[int], ...]) -> Compared:  # type: ignore[override]
        return Compared(*(sorted(a + b) for a, b in zip(self, other, strict=True)))


def compare_crossings(truth: Sequence[int], counted: Sequence[int]) -> Compared:
    """Compare the frames of crossings of a line in one direction.

    A true crossing is counted if a counted one is within `WITHIN` frames, one to one, as many as
    can be.
    """
    off = np.abs(np.subtract.outer(np.array(truth, float), np.array(counted, float)))
    pairs = assign(np.where(off <= WITHIN, off, np.inf)) if off.size else []
    found, used = {i for i, _ in pairs}, {j for _, j in pairs}
    return Compared(
        sorted(each for i, each in enumerate(truth) if i in found),
        sorted(each for i, each in enumerate(truth) if i not in found),
        sorted(each for j, each in enumerate(counted) if j not in used),
    )


def figure10(clips: CountedClips, folder: Path) -> Experiment:
    """Yield the crossings that a scene counts in a folder's films, beside the true ones."""
    rows, total = list[Row](), Compared([], [], [])
    for done, clip in enumerate(clips.clip, start=1):
        events = _events(clip, str(folder / clip.file))
        for n, line in enumerate(clip.line, start=1):
            own = _compared(line, [each for each in events if each.place == str(n)])
            total += own
            points = ",".join(f"{value:g}" for value in line.points)
            rows.append(_row(f"{clip.file} {points}", own, frames=True))
        note = f"A crossing is counted within {WITHIN} frames, in its direction."
        table = Table("Crossings", HEAD, rows, (_row("all", total, frames=False),), note)
        yield Result({"": table}, progress=f"{done} of {len(clips.clip)} films")


def _events(clip: CountedClip, source: str) -> list[Event]:
    """Return the crossings that are counted in a film; a line's name is its number."""
    lines = tuple(
        Line(line.points, str(n), ("left", "right")) for n, line in enumerate(clip.line, start=1)
    )
    scene = Scene(named_detector("background"))
    with open_source(source) as film:
        scene.prepare(film)
    with open_source(source) as film:
        counter = EventCounter(Regions(lines), (film.width, film.height))
        events = [event for _, tracks in scene.watch(film) for event in counter.update(tracks)]
    return [each for each in [*events, *counter.finish()] if each.event == "crosses"]


def _compared(line: CrossedLine, events: list[Event]) -> Compared:
    """Return the comparison of both directions together."""
    left, right = (
        compare_crossings(truth, [each.frame for each in events if each.direction == side])
        for side, truth in (("left", line.left), ("right", line.right))
    )
    return left + right


def _row(name: str, compared: Compared, *, frames: bool) -> Row:
    """Return the row of a line, or of all."""
    counts = [len(each) for each in compared]
    numbers = [sum(counts[:2]), *counts]
    texts = [" ".join(map(str, each)) if frames else "" for each in compared[1:]]
    return (Cell(name), *(number(each, 0) for each in numbers), *map(Cell, texts))
