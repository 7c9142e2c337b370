"""Fit the calibration of a preset's confidence, and test it on sequences left out of the fit.

    python benchmarks/calibration.py [--seeds 2] [--data FOLDER] [--films FILM ...] [PRESET ...]

The confidence is a logistic function of the estimate's distance and of the logarithm of the
particles' spread; without a power of the spread it is multiplied by the weight of the particles
that fulfill the appearance rule. The numbers are chosen on a grid for the least log loss of
"IoU > 0.5" in the first 150 frames, each sequence counting the same. The error for left-out
sequences comes from choices that have not seen the sequence they are tested on.

FOLDER holds sequences in OTB's layout (those that begin with seg- are 0-based); the default is
$MOTES_DATA/sot or ../shared/data/sot. Each FILM has its truth beside it, as cup.txt of cup.mp4.
"""

from __future__ import annotations

import argparse
import math
import os
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from functools import cache
from itertools import islice
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
FRAMES = 150
MIDDLES, WIDTHS = np.arange(0, 1.01, 0.02), np.arange(0.02, 0.61, 0.02)
POWERS = np.arange(0.25, 4.1, 0.25)


@dataclass(frozen=True)
class Run:
    """One tracker on one sequence with one seed, frame by frame."""

    correct: NDArray[np.bool_]
    confidence: Floats
    distances: Floats
    spreads: Floats


@cache
def load(path: Path) -> tuple[Sequence, list[Frame]]:
    first_pixel = {"*": 0} if path.name.startswith("seg-") else {}
    truth = path.with_suffix(".txt") if path.is_file() else None
    sequences, problems = load_dataset(path, first_pixel, truth)
    assert not problems, problems
    with open_source(sequences[0].source) as source:
        return sequences[0], list(islice(source, FRAMES))


def follow(name: str, path: Path, seed: int) -> Run:
    sequence, frames = load(path)
    tracker = Tracker(name, seed)
    tracks = [tracker.init(frames[0], sequence.boxes[0].tolist())]
    tracks += [tracker.update(frame) for frame in frames[1:]]
    truth = np.nan_to_num(sequence.boxes[: len(frames)])
    overlaps = iou(np.array([track.box for track in tracks]), truth)
    areas = [np.linalg.det(track.covariance[:2, :2]).clip(0) ** 0.5 for track in tracks]
    return Run(
        overlaps > 0.5,
        np.array([track.confidence for track in tracks]),
        np.array([track.distance for track in tracks]),
        np.sqrt([area / math.prod(t.ellipse[2:4]) for area, t in zip(areas, tracks, strict=True)]),
    )


def confidences(run: Run, shipped: Calibration) -> Floats:
    """Return the confidence of each frame for all settings, (middles, widths, powers, frames)."""
    out: Floats
    steps = (run.distances - MIDDLES[:, None, None, None]) / WIDTHS[:, None, None]
    if shipped.spread:
        spreads = np.log(4 * run.spreads.clip(1e-3))
        out = 1 / (1 + np.exp(steps + POWERS[:, None] * spreads))
        return out
    shares = run.confidence / [shipped.probability(d) for d in run.distances]
    out = shares / (1 + np.exp(steps))
    return out


def loss(run: Run, shipped: Calibration) -> Floats:
    """Return the mean log loss of a run for all settings, (middles, widths, powers)."""
    sure = np.clip(confidences(run, shipped), 1e-3, 1 - 1e-3)
    mean: Floats = -np.log(np.where(run.correct, sure, 1 - sure)).mean(axis=-1)
    return mean


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("presets", nargs="*", default=list(PRESETS))
    parser.add_argument("--seeds", type=int, default=2)
    parser.add_argument("--data", type=Path, default=DATA)
    parser.add_argument("--films", type=Path, nargs="*", default=[])
    options = parser.parse_args()
    paths = sorted(path.parent for path in options.data.glob("*/groundtruth_rect.txt"))
    paths += options.films
    print("| preset | middle | width | spread | ECE, left-out fits | ECE as shipped |")
    print("|---|---|---|---|---|---|")
    with ProcessPoolExecutor(os.cpu_count()) as pool:
        for name in options.presets:
            shipped = getattr(preset(name), "calibration", None)
            if shipped is None:  # the default tracker's confidence is that of its evidence
                continue
            jobs = [(name, path, seed) for path in paths for seed in range(options.seeds)]
            runs = list(pool.map(follow, *zip(*jobs, strict=True), chunksize=options.seeds))
            losses = np.array([loss(run, shipped) for run in runs])
            best = np.unravel_index(losses.sum(axis=0).argmin(), losses.shape[1:])
            left_out = []
            for (_, path, _), run in zip(jobs, runs, strict=True):
                others = [other != path for _, other, _ in jobs]
                choice = np.unravel_index(losses[others].sum(axis=0).argmin(), losses.shape[1:])
                left_out.append(confidences(run, shipped)[choice])
            right = np.concatenate([run.correct for run in runs])
            sizes = np.array([run.correct.size for run in runs])
            weights = np.repeat(1 / sizes, sizes)
            as_shipped = np.concatenate([run.confidence for run in runs])
            print(
                f"| {name} | {MIDDLES[best[0]]:.2f} | {WIDTHS[best[1]]:.2f} "
                f"| {POWERS[best[2]] if shipped.spread else 0:.2f} "
                f"| {calibration_error(np.concatenate(left_out), right, weights):.3f} "
                f"| {calibration_error(as_shipped, right, weights):.3f} |",
                flush=True,
            )


if __name__ == "__main__":
    main()
