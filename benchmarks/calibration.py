"""Fit the calibration of a preset's confidence, and test it on sequences left out of the fit.

    python benchmarks/calibration.py [--seeds 2] [--data FOLDER] [PRESET ...]

The confidence is a logistic function of the estimate's distance times the weight of the particles
that fulfill the appearance rule. Middle and width are chosen on a grid for the least log loss of
"IoU > 0.5", each sequence counting the same. The error for left-out sequences comes from choices
that have not seen the sequence they are tested on.
"""

from __future__ import annotations

import argparse
import os
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from accuracy import DATA, Run, follow
from motes import PRESETS
from motes.evaluate.metrics import calibration_error
from motes.presence import Calibration
from motes.presets import preset

Floats = NDArray[np.float64]


MIDDLES, WIDTHS = np.arange(0, 0.81, 0.01), np.arange(0.02, 0.21, 0.01)


def confidences(run: Run, shipped: Calibration) -> Floats:
    """Return the confidence of each frame for all settings, (middles, widths, frames)."""
    shares = run.confidence / [shipped.probability(d) for d in run.distances]
    steps = (run.distances - MIDDLES[:, None, None]) / WIDTHS[:, None]
    out: Floats = shares / (1 + np.exp(steps))
    return out


def loss(run: Run, shipped: Calibration) -> Floats:
    """Return the mean log loss of a run for all settings, (middles, widths)."""
    sure = np.clip(confidences(run, shipped), 1e-3, 1 - 1e-3)
    right = np.nan_to_num(run.overlaps) > 0.5
    mean: Floats = -np.log(np.where(right, sure, 1 - sure)).mean(axis=-1)
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
            shipped = preset(name).calibration
            jobs = [(name, folder, seed) for folder in folders for seed in range(options.seeds)]
            runs = list(pool.map(follow, *zip(*jobs, strict=True), chunksize=options.seeds))
            losses = np.array([loss(run, shipped) for run in runs])
            best = np.unravel_index(losses.sum(axis=0).argmin(), losses.shape[1:])
            left_out = []
            for (_, folder, _), run in zip(jobs, runs, strict=True):
                others = [other != folder for _, other, _ in jobs]
                choice = np.unravel_index(losses[others].sum(axis=0).argmin(), losses.shape[1:])
                left_out.append(confidences(run, shipped)[choice])
            right = np.nan_to_num(np.concatenate([run.overlaps for run in runs])) > 0.5
            weights = np.concatenate([np.full(run.lost.size, 1 / run.lost.size) for run in runs])
            as_shipped = np.concatenate([run.confidence for run in runs])
            print(
                f"| {name} | {MIDDLES[best[0]]:.2f} | {WIDTHS[best[1]]:.2f} "
                f"| {calibration_error(np.concatenate(left_out), right, weights):.3f} "
                f"| {calibration_error(as_shipped, right, weights):.3f} |",
                flush=True,
            )


if __name__ == "__main__":
    main()
