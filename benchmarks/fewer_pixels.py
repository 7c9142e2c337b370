"""Processor time of an update of `ng_delp` with all, half and a quarter of the pixels.

    python benchmarks/fewer_pixels.py

Ng and Delp, section 3.5: fewer pixels are faster. Decoding is not counted, and all else is: the
dense edges, the filter and its estimate. Variants are measured in turn on the same frames.
"""

from __future__ import annotations

import sys
import time

import numpy as np

from motes import Tracker, synthetic
from motes.core.frame import Frame
from motes.sot.presets import NG_DELP, configure
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


def milliseconds(target: tuple[int, int]) -> list[float]:
    """Return the median time of an update with each of `PIXELS`."""
    clip = synthetic.still(FILM, target=target, frames=FRAMES)
    trackers = [
        Tracker(configure(NG_DELP, {cue: {"sampling": sampling} for cue in NG_DELP.cues}))
        for sampling in PIXELS.values()
    ]
    taken = np.empty((FRAMES, len(trackers)))
    for frame, (truth,) in clip:
        for column in np.roll(np.arange(len(trackers)), frame.index):  # the first one is slower
            tracker = trackers[column]
            own = Frame(frame.index, frame.time, frame.pixels)
            start = time.process_time()
            tracker.update(own) if frame.index else tracker.init(own, truth.ellipse)
            taken[frame.index, column] = time.process_time() - start
    medians: list[float] = (1000 * np.median(taken[STARTING:], axis=0)).tolist()
    return medians


def main() -> int:
    """Print the table."""
    rows: list[Row] = []
    for width, height in TARGETS:
        times = milliseconds((width, height))
        shares = [percent(each / times[0]) for each in times[1:]]
        rows.append((Cell(f"{width}x{height}"), *(number(each, 2) for each in times), *shares))
    head = ("target", *(f"{name}, ms" for name in PIXELS), "half against all", "quarter")
    print(markdown.table(Table("An update of ng_delp", head, rows)))
    return 0


if __name__ == "__main__":
    sys.exit(main())
