"""Time of an update of `OpenCVTracker` on BGR images beside `Tracker` on the same RGB images.

    python benchmarks/bgr.py [PRESET ...]

Both take turns on images that have just been written. A time is the shortest of 40 of the same
update, which load of the machine does not reach, and the mean of that over 30 updates.
"""

from __future__ import annotations

import copy
import sys
import time

import numpy as np

from motes.sot.opencv_api import OpenCVTracker
from motes.sot.tracker import Tracker
from motes.synthetic.clips import still
from motes_lab.report import markdown
from motes_lab.report.tables import Cell, Row, Table, number
from motes_lab.speed.measure import MAIN, SIZE

ROUNDS, UPDATES = 40, 30


def milliseconds(preset: str) -> tuple[float, float]:
    """Return the times of an update: of `Tracker` on RGB, and of `OpenCVTracker` on BGR."""
    clip = [*still(SIZE, MAIN, UPDATES + 1)]
    box = [round(value) for value in clip[0][1][0].ellipse.box]
    rgb = [frame.pixels for frame, _ in clip]
    films = (rgb, [np.ascontiguousarray(pixels[:, :, ::-1]) for pixels in rgb])
    started = (Tracker(preset), OpenCVTracker(preset))
    started[0].init(films[0][0], box)
    started[1].init(films[1][0], box)
    seconds = np.full((2, UPDATES), np.inf)
    for turn in range(ROUNDS):
        trackers = copy.deepcopy(started)
        for update in range(UPDATES):
            for which in (0, 1) if (turn + update) % 2 else (1, 0):
                image = films[which][update + 1].copy()
                start = time.perf_counter()
                trackers[which].update(image)
                elapsed = time.perf_counter() - start
                seconds[which, update] = min(seconds[which, update], elapsed)
    one, other = (1e3 * seconds.mean(axis=1)).tolist()
    return one, other


def main() -> None:
    """Print the table."""
    rows: list[Row] = []
    for name in sys.argv[1:] or ["nummiaro", "ng_delp", "maggio", "default"]:
        rgb, bgr = milliseconds(name)
        rows.append((Cell(name), *map(number, (rgb, bgr, bgr / rgb))))
    head = "update", "Tracker, RGB, ms", "OpenCVTracker, BGR, ms", "ratio"
    print(markdown.table(Table("An update on BGR images", head, rows)))


if __name__ == "__main__":
    main()
