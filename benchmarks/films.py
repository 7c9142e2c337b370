"""How many times as long CSRT takes as the default tracker, on films as a program reads them.

    python benchmarks/films.py FILMS [--frames 60]

FILMS is a folder of `NAME.mp4` with the boxes of the target in `NAME.txt`, of which the first is
taken. Both trackers are OpenCV's to the program: they get each BGR image in turn. The medians of
their updates are compared.
"""

from __future__ import annotations

import argparse
import re
import time
from pathlib import Path

import cv2
import numpy as np

from motes import OpenCVTracker
from motes.core.types import Floats


def ratio(film: Path, frames: int) -> float:
    """Return the time of CSRT's updates on a film in that of the default tracker's."""
    first = film.with_suffix(".txt").read_text(encoding="utf-8").splitlines()[0]
    box = tuple(round(float(number)) for number in re.split(r"[,\s]+", first.strip())[:4])
    trackers = OpenCVTracker.create(), cv2.TrackerCSRT.create()
    reader, spent = cv2.VideoCapture(str(film)), list[Floats]()
    _, image = reader.read()
    for tracker in trackers:
        tracker.init(image, box)
    while len(spent) < frames and (read := reader.read())[0]:
        times = [time.perf_counter()]
        for tracker in trackers:
            tracker.update(read[1])
            times.append(time.perf_counter())
        spent.append(np.diff(times))
    ours, theirs = np.median(spent, axis=0).tolist()
    return float(theirs / ours)


def main() -> None:
    """Print the ratio of each film, and how they spread."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("folder", type=Path)
    parser.add_argument("--frames", type=int, default=60)
    given = parser.parse_args()
    found = []
    for film in sorted(given.folder.glob("*.mp4")):
        found.append(ratio(film, given.frames))
        print(f"{film.stem:20} {found[-1]:.2f}", flush=True)
    low, middle, high = np.quantile(found, (0.25, 0.5, 0.75))
    print(f"{len(found)} films: median {middle:.2f}, half of them {low:.2f} to {high:.2f}")


if __name__ == "__main__":
    main()
