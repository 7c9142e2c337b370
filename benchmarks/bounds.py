"""What a tracker's success lacks: its AUC if a part of each region were the truth's.

    python benchmarks/bounds.py RUN SEQUENCES [--first-pixel 'seg-*=0' ...]

RUN is a folder of `motes-lab evaluate` over SEQUENCES. The tracks are corrected, not tracked again,
so this tells where the success lies that is missing, not what a better estimate would lead to.
"""

from __future__ import annotations

import argparse
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from urllib.parse import unquote

import numpy as np

from motes.core.types import Floats
from motes_lab.datasets.sot import Sequence, load_dataset
from motes_lab.metrics.sot import success_auc
from motes_lab.protocols.trace import TrackerOutput, load_trace
from motes_lab.report import markdown
from motes_lab.report.tables import Cell, Table, number
from motes_lab.scores import MISS_IOU, fit

Correction = Callable[[Floats, Floats], None]
"""Changes rows x, y, a, b, theta of a track, given those of the truth's boxes."""


def center(rows: Floats, truths: Floats) -> None:
    rows[:, :2] = truths[:, :2]


def area(rows: Floats, truths: Floats) -> None:
    rows[:, 2:4] *= np.sqrt(truths[:, 2:4].prod(1) / rows[:, 2:4].prod(1))[:, None]


def proportions(rows: Floats, truths: Floats) -> None:
    own, true = rows[:, 2] / rows[:, 3], truths[:, 2] / truths[:, 3]
    rows[:, 2] *= np.sqrt(true / own)
    rows[:, 3] *= np.sqrt(own / true)


CORRECTIONS: dict[str, Correction] = {
    "center": center,
    "area": area,
    "proportions": proportions,
}


def corrected(trace: TrackerOutput, sequence: Sequence, correction: Correction) -> Floats:
    """Return the overlaps if all frames that are not missed were corrected."""
    found = fit(trace, sequence)
    rows = found.rows[found.present & ~found.missed]
    boxes = sequence.boxes[trace.frames[rows]]
    truths = np.column_stack([boxes[:, :2] + boxes[:, 2:] / 2, boxes[:, 2:] / 2])
    ellipses = trace.ellipses.copy()
    better = ellipses[rows]
    correction(better, truths)
    ellipses[rows] = better
    return present(replace(trace, ellipses=ellipses), sequence)


def present(trace: TrackerOutput, sequence: Sequence) -> Floats:
    """Return the overlaps of the frames with a target."""
    found = fit(trace, sequence)
    overlaps: Floats = found.overlaps[found.present]
    return overlaps


def bounds(trace: TrackerOutput, sequence: Sequence) -> dict[str, float]:
    """Return the AUC as it is, with each correction, and without the frames that are missed."""
    overlaps = present(trace, sequence)
    kept = overlaps[overlaps >= MISS_IOU]
    return {
        "as it is": success_auc(overlaps),
        **{f"true {n}": success_auc(corrected(trace, sequence, c)) for n, c in CORRECTIONS.items()},
        f"frames below an IoU of {MISS_IOU:g} left out": success_auc(kept) if len(kept) else 0.0,
    }


def main() -> None:
    """Print a table for each tracker of the run."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("run", type=Path)
    parser.add_argument("sequences", type=Path)
    parser.add_argument("--first-pixel", nargs="*", default=[])
    options = parser.parse_args()
    first = {glob: int(pixel) for glob, pixel in (v.rsplit("=", 1) for v in options.first_pixel)}
    sequences, problems = load_dataset(options.sequences, first)
    assert not problems, problems
    for folder in sorted((options.run / "tracks").iterdir()):
        means = []
        for sequence in sequences:
            traces = [load_trace(path) for path in sorted((folder / sequence.name).glob("*.csv"))]
            found = [bounds(trace, sequence) for trace in traces]
            means.append({name: np.mean([each[name] for each in found]) for name in found[0]})
        rows: list[tuple[Cell, ...]] = [
            (Cell(name), number(float(np.mean([each[name] for each in means])), 3))
            for name in means[0]
        ]
        print(markdown.table(Table(unquote(folder.name), ("each region has", "AUC"), rows)))


if __name__ == "__main__":
    main()
