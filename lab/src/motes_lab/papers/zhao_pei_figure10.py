"""Zhao and Pei, figure 10: objects that are detected, tracked and counted, on films."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from motes.core.detection import Detector, PreparedDetector
from motes.mot.analytics.events import Event, EventCounter
from motes.mot.analytics.regions import Line, Regions
from motes.mot.scene import Scene
from motes.video.sources import open_source
from motes_lab.datasets.crossings import CountedClip, CountedClips, CrossedLine
from motes_lab.metrics.crossings import WITHIN, Compared, compare_crossings
from motes_lab.papers.result import Experiment, Result
from motes_lab.report.tables import Cell, Row, Table, number

HEAD = ("film and line", "true", "counted", "missed", "false", "frames missed", "frames false")


def figure10(
    clips: CountedClips, folder: Path, make: Callable[[], Detector], preset: str, seed: int
) -> Experiment:
    """Yield the crossings that a scene counts, film by film, beside the true ones.

    Parameters
    ----------
    clips
        The films and their true crossings.
    folder
        Where the films are.
    make
        Makes the detector; each film has its own.
    preset, seed
        Preset and seed of the scene.

    Raises
    ------
    SourceError
        If a film cannot be read.
    """
    rows, total = list[Row](), Compared([], [], [])
    for done, clip in enumerate(clips.clip, start=1):
        events = _events(clip, str(folder / clip.file), make(), preset, seed)
        for n, line in enumerate(clip.line, start=1):
            own = _compared(line, [each for each in events if each.place == str(n)])
            total += own
            points = ",".join(f"{value:g}" for value in line.points)
            rows.append(_row(f"{clip.file} {points}", own, frames=True))
        note = f"A crossing is counted within {WITHIN} frames, in its direction."
        table = Table("Crossings", HEAD, rows, (_row("all", total, frames=False),), note)
        yield Result({"": table}, progress=f"{done} of {len(clips.clip)} films")


def _events(
    clip: CountedClip, source: str, detector: Detector, preset: str, seed: int
) -> list[Event]:
    """Return the crossings that are counted in a film; a line's name is its number."""
    lines = tuple(
        Line(line.points, str(n), ("left", "right")) for n, line in enumerate(clip.line, start=1)
    )
    if isinstance(detector, PreparedDetector):
        with open_source(source) as film:
            detector.prepare(film)
    counter, scene = EventCounter(Regions(lines)), Scene(detector, preset, seed)
    with open_source(source) as film:
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
