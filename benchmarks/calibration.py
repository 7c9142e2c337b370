"""Fit the calibration of a preset's confidence, and test it on sequences left out of the fit.

    python benchmarks/calibration.py [--seeds 2] [--data FOLDER] [PRESET ...]

The confidence is a logistic function of the estimate's distance times the weight of the particles
that fulfill the appearance rule. Middle and width are chosen on a grid for the least log loss of
"IoU > 0.5", each sequence counting the same. The error for left-out sequences comes from choices
that have not seen the sequence they are tested on.

FOLDER holds sequences in OTB's layout (those that begin with seg- are 0-based); the default is
$MOTES_DATA/sot or ../shared/data/sot.
"""

from __future__ import annotations

import argparse
import os
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from functools import cache
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from motes import PRESETS, Frame, Tracker, open_source
from motes.core.geometry import iou
from motes.sot.filtering.appearance_rule import Calibration
from motes.sot.presets import preset
from motes_lab.datasets.sot import Sequence, load_dataset
from motes_lab.metrics.sot import calibration_error

Floats = NDArray[np.float64]

HERE = Path(__file__).resolve().parent
DATA = Path(os.environ.get("MOTES_DATA", HERE.parent.parent / "shared" / "data")) / "sot"
MIDDLES, WIDTHS = np.arange(0, 0.81, 0.01), np.arange(0.02, 0.21, 0.01)


@dataclass(frozen=True)
class Run:
    """One tracker on one sequence with one seed, frame by frame."""

    correct: NDArray[np.bool_]
    confidence: Floats
    distances: Floats


@cache
def load(folder: Path) -> tuple[Sequence, list[Frame]]:
    first_pixel = {"*": 0} if folder.name.startswith("seg-") else {}
    sequences, problems = load_dataset(folder, first_pixel)
    assert not problems, problems
    with open_source(sequences[0].source) as source:
        return sequences[0], list(source)


def follow(name: str, folder: Path, seed: int) -> Run:
    sequence, frames = load(folder)
    tracker = Tracker(name, seed)
    tracks = [tracker.init(frames[0], sequence.boxes[0].tolist())]
    tracks += [tracker.update(frame) for frame in frames[1:]]
    overlaps = iou(np.array([track.box for track in tracks]), np.nan_to_num(sequence.boxes))
    return Run(
        overlaps > 0.5,
        np.array([track.confidence for track in tracks]),
        np.array([track.distance for track in tracks]),
    )


def confidences(run: Run, shipped: Calibration) -> Floats:
    """Return the confidence of each frame for all settings, (middles, widths, frames)."""
    shares = run.confidence / [shipped.probability(d) for d in run.distances]
    steps = (run.distances - MIDDLES[:, None, None]) / WIDTHS[:, None]
    out: Floats = shares / (1 + np.exp(steps))
    return out


def loss(run: Run, shipped: Calibration) -> Floats:
    """Return the mean log loss of a run for all settings, (middles, widths)."""
    sure = np.clip(confidences(run, shipped), 1e-3, 1 - 1e-3)
    mean: Floats = -np.log(np.where(run.correct, sure, 1 - sure)).mean(axis=-1)
    return mean


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("presets", nargs="*", default=list(PRESETS))
    parser.add_argument("--seeds", type=int, default=2)
    parser.add_argument("--data", type=Path, default=DATA)
    options = parser.parse_args()
    folders = sorted(path.parent for path in options.data.glob("*/groundtruth_rect.txt"))
    print("| preset | middle | width | ECE, left-out fits | ECE as shipped |")
    print("|---|---|---|---|---|")
    with ProcessPoolExecutor(os.cpu_count()) as pool:
        for name in options.presets:
            shipped = getattr(preset(name), "calibration", None)
            if shipped is None:  # the default tracker's confidence is that of its evidence
                continue
            jobs = [(name, folder, seed) for folder in folders for seed in range(options.seeds)]
            runs = list(pool.map(follow, *zip(*jobs, strict=True), chunksize=options.seeds))
            losses = np.array([loss(run, shipped) for run in runs])
            best = np.unravel_index(losses.sum(axis=0).argmin(), losses.shape[1:])
            left_out = []
            for (_, folder, _), run in zip(jobs, runs, strict=True):
                others = [other != folder for _, other, _ in jobs]
                choice = np.unravel_index(losses[others].sum(axis=0).argmin(), losses.shape[1:])
                left_out.append(confidences(run, shipped)[choice])
            right = np.concatenate([run.correct for run in runs])
            sizes = np.array([run.correct.size for run in runs])
            weights = np.repeat(1 / sizes, sizes)
            as_shipped = np.concatenate([run.confidence for run in runs])
            print(
                f"| {name} | {MIDDLES[best[0]]:.2f} | {WIDTHS[best[1]]:.2f} "
                f"| {calibration_error(np.concatenate(left_out), right, weights):.3f} "
                f"| {calibration_error(as_shipped, right, weights):.3f} |",
                flush=True,
            )


if __name__ == "__main__":
    main()
