"""Processor time of an update of `ng_delp` with all, half and a quarter of the pixels.

    python benchmarks/fewer_pixels.py [SEQUENCE ...]

Ng and Delp, section 3.5: fewer pixels are faster. Films are rendered, or sequences as of `motes-lab
evaluate`. Decoding is not counted, and all else is: the dense edges, the filter and its estimate.
Variants are measured in turn on the same frames.
"""

from __future__ import annotations

import itertools
import sys
import time
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from motes import Tracker, synthetic
from motes.core.frame import Frame
from motes.core.geometry import Ellipse
from motes.sot.presets import NG_DELP, configure
from motes.video.sources import open_source
from motes_lab.datasets.sot import load_dataset
from motes_lab.report import markdown
from motes_lab.report.tables import Cell, Row, Table, number, percent

FILM = 352, 240
"""The size of the paper's film of a bus."""
TARGETS = (10, 30), (20, 60), (40, 80), (60, 100), (120, 180)
"""Width and height of the targets; the first is the paper's."""
PIXELS = {
    "all": {"type": "every_pixel"},
    "half": {"type": "checkerboard", "share": "half"},
    "quarter": {"type": "checkerboard", "share": "quarter"},
}
FRAMES, STARTING = 130, 10


def rendered(target: tuple[int, int]) -> tuple[Ellipse, list[Frame]]:
    """Return a target at rest, and the frames of its film."""
    shots = list(synthetic.still(FILM, target=target, frames=FRAMES))
    return Ellipse(*shots[0][1][0].ellipse), [frame for frame, _ in shots]


def filmed(folder: Path) -> tuple[Ellipse, list[Frame]]:
    """Return the first region of a sequence, and its frames."""
    [film, *_], _ = load_dataset(folder)
    with open_source(film.source) as frames:
        return Ellipse(*film.ellipses[0]), list(itertools.islice(frames, FRAMES))


def milliseconds(first: Ellipse, frames: list[Frame]) -> list[float]:
    """Return the median time of an update with each of `PIXELS`."""
    trackers = [
        Tracker(configure(NG_DELP, {cue: {"sampling": sampling} for cue in NG_DELP.cues}))
        for sampling in PIXELS.values()
    ]
    taken = np.empty((len(frames), len(trackers)))
    for frame in frames:
        for column in np.roll(np.arange(len(trackers)), frame.index):  # the first one is slower
            tracker = trackers[column]
            own = Frame(frame.index, frame.time, frame.pixels)
            start = time.process_time()
            tracker.update(own) if frame.index else tracker.init(own, first)
            taken[frame.index, column] = time.process_time() - start
    medians: list[float] = (1000 * np.median(taken[STARTING:], axis=0)).tolist()
    return medians


def main(sequences: Sequence[str] = ()) -> int:
    """Print the table."""
    films = [("rendered", *rendered(target)) for target in TARGETS if not sequences]
    films += [(Path(each).name, *filmed(Path(each))) for each in sequences]
    rows: list[Row] = []
    for name, first, frames in films:
        times = milliseconds(first, frames)
        shares = [percent(each / times[0]) for each in times[1:]]
        size = Cell(f"{first.box.width:.0f}x{first.box.height:.0f}")
        rows.append((Cell(name), size, *(number(t, 2) for t in times), *shares))
    head = ("film", "target", *(f"{name}, ms" for name in PIXELS), "half against all", "quarter")
    print(markdown.table(Table("An update of ng_delp", head, rows)))
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
