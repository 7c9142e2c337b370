"""Write a dataset of the MOTChallenge with only the surer half of its detections.

    python benchmarks/surer_half.py MOT OUT
    motes-lab evaluate OUT --seeds 5 --tracker motes:scene --tracker trackers:bytetrack

In each sequence those detections stay whose score is at least the median. Frames and truth are
links to the originals.
"""

from __future__ import annotations

import argparse
from pathlib import Path

import numpy as np

SCORE = 6
"""Column of a detection's score in det.txt."""


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("dataset", type=Path)
    parser.add_argument("out", type=Path)
    options = parser.parse_args()
    for detections in sorted(options.dataset.resolve().glob("*/det/det.txt")):
        sequence = detections.parents[1]
        copy = options.out / sequence.name
        (copy / "det").mkdir(parents=True)
        for each in sequence.iterdir():
            if each.name != "det":
                (copy / each.name).symlink_to(each)
        lines = detections.read_text().splitlines()
        scores = np.array([float(line.split(",")[SCORE]) for line in lines])
        surer = scores >= np.median(scores)
        kept = [line for line, stays in zip(lines, surer.tolist(), strict=True) if stays]
        (copy / "det" / "det.txt").write_text("\n".join(kept) + "\n")


if __name__ == "__main__":
    main()
