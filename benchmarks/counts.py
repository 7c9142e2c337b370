"""What `motes watch` counts at lines, beside the truth: found, missed and false crossings.

    python benchmarks/counts.py DATA [--half choose|check] [--only NAME]

DATA has video/ and mot/. The settings are those of `motes watch` without options. Truth is by eye
for films (lab/tests/truth/crossings.toml), from the boxes of the MOTChallenge, and known for
rendered roads (`rendered_roads.py`). A change is chosen on one half and checked on the other, and
no film is in both. A crossing is found within a second, in its direction.
"""

from __future__ import annotations

import argparse
import itertools
from collections.abc import Callable, Iterator
from functools import partial
from pathlib import Path
from typing import NamedTuple

import numpy as np

import rendered_roads
from motes.core.frame import Frame
from motes.mot.analytics.events import CLEAR, EventCounter
from motes.mot.analytics.regions import Line, Regions
from motes.mot.detection.background import BackgroundDetector
from motes.mot.scene import Scene
from motes.video.sources import open_source
from motes_lab.datasets.crossings import parse_crossings
from motes_lab.datasets.mot import MotSequence, load_mot_dataset
from motes_lab.metrics.crossings import Compared, compare_crossings
from motes_lab.report import markdown
from motes_lab.report.tables import Cell, Row, Table

CHOOSE = ("car_traffic_small", "one-by-one-person-detection", "PETS09-S2L1-first200", "TUD-Campus")
CHECK = ("pycv_movie", "TUD-Stadtmitte")
ROADS = {"choose": range(6), "check": range(100, 106)}
BY_EYE = Path(__file__).parents[1] / "lab/tests/truth/crossings.toml"


class Truth(NamedTuple):
    """A line's points, and the frames in which it is crossed to its left and to its right."""

    points: tuple[float, float, float, float]
    left: list[int]
    right: list[int]


class Clip(NamedTuple):
    """A film, by name: what opens it, its frames a second, and its lines."""

    name: str
    frames: Callable[[], Iterator[Frame]]
    rate: float
    lines: list[Truth]


def clips(data: Path, half: str) -> Iterator[Clip]:
    """Yield the clips of a half."""
    names = CHOOSE if half == "choose" else CHECK
    for each in parse_crossings(BY_EYE.read_text(), str(BY_EYE)).clip:
        path = data / "video" / each.file
        if path.stem in names and path.exists():
            lines = [Truth(line.points, [*line.left], [*line.right]) for line in each.line]
            yield Clip(path.stem, opener(path), 25.0, lines)
    for crowd in load_mot_dataset(data / "mot")[0]:
        if crowd.name in names:
            yield Clip(crowd.name, opener(crowd.source), crowd.rate, walked(crowd))
    for seed in ROADS[half]:
        road = rendered_roads.road(seed)
        line = Truth(road.line, *road.crossings())
        yield Clip(f"road {seed}", partial(rendered_roads.frames, road, seed), 25.0, [line])


def opener(path: str | Path) -> Callable[[], Iterator[Frame]]:
    """Return what reads a film."""

    def frames() -> Iterator[Frame]:
        with open_source(path) as film:
            yield from film

    return frames


def walked(crowd: MotSequence) -> list[Truth]:
    """Return upright lines at each quarter of a picture's width, and who crosses them by the truth.

    Who comes back at once, as far as counting asks a foot to be clear of a line, has not crossed.
    """
    with open_source(crowd.source) as film:
        first = next(iter(film))
    rows, lines = crowd.truth, []
    for x in (first.width * n / 4 for n in (1, 2, 3)):
        crossed: tuple[list[int], list[int]] = ([], [])
        for one in np.unique(rows.ids):
            mine = np.flatnonzero(rows.ids == one)
            mine = mine[np.argsort(rows.frames[mine])]
            boxes = rows.boxes[mine]
            away = boxes[:, 0] + boxes[:, 2] / 2 - x
            sure = np.flatnonzero(np.abs(away) >= CLEAR * boxes[:, 3])
            for a, b in itertools.pairwise(sure):
                if away[a] * away[b] < 0:
                    crossed[int(away[b] < 0)].append(int(rows.frames[mine[b]]) - 1)
        line = float(x), 0.0, float(x), float(first.height)
        lines.append(Truth(line, sorted(crossed[0]), sorted(crossed[1])))
    return lines


def counted(clip: Clip, seed: int) -> Iterator[Compared]:
    """Yield for each line what is counted."""
    named = [Line(each.points, str(n), ("left", "right")) for n, each in enumerate(clip.lines)]
    detector = BackgroundDetector()
    detector.prepare(clip.frames())
    counter, scene = EventCounter(Regions(tuple(named))), Scene(detector, seed=seed)
    events = [event for _, tracks in scene.watch(clip.frames()) for event in counter.update(tracks)]
    events = [each for each in [*events, *counter.finish()] if each.event == "crosses"]
    for n, line in enumerate(clip.lines):
        own = [each for each in events if each.place == str(n)]
        left, right = (
            compare_crossings(true, [e.frame for e in own if e.direction == side], clip.rate)
            for side, true in (("left", line.left), ("right", line.right))
        )
        yield left + right


def row(name: str, total: Compared) -> Row:
    """Return a row of the table."""
    found, missed, false = map(len, total)
    where = (" ".join(map(str, each)) for each in (total.missed, total.false))
    numbers = (Cell(f"{each}") for each in (found + missed, found, missed, false))
    return Cell(name), *numbers, *map(Cell, where)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("data", type=Path)
    parser.add_argument("--half", choices=("choose", "check"), default="choose")
    parser.add_argument("--only", default="")
    parser.add_argument("--seed", type=int, default=0)
    options = parser.parse_args()
    rows, all_clips = list[Row](), Compared([], [], [])
    for clip in clips(options.data, options.half):
        if options.only in clip.name:
            own = sum(counted(clip, options.seed), Compared([], [], []))
            rows.append(row(clip.name, own))
            all_clips += own
    foot = *row("all", all_clips)[:5], Cell(""), Cell("")
    head = "clip", "true", "found", "missed", "false", "frames missed", "frames false"
    title = f"Crossings of the half to {options.half}"
    print(markdown.table(Table(title, head, rows, (foot,))))


if __name__ == "__main__":
    main()
