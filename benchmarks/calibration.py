"""Fit the calibration of a preset's confidence, and test it on sequences left out of the fit.

    python benchmarks/calibration.py [--seeds 2] [--data FOLDER] [PRESET ...]

Logistic regression of "IoU > 0.5" on the estimate's distance, each sequence counting the same. The
error for left-out sequences comes from fits that have not seen the sequence they are tested on.
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

Floats = NDArray[np.float64]


def fit(distances: Floats, correct: NDArray[np.bool_], weights: Floats) -> Floats:
    """Return the weighted logistic regression's intercept and slope, by Newton's method."""
    design = np.stack([np.ones_like(distances), distances], axis=1)
    beta = np.zeros(2)
    for _ in range(50):
        p = 1 / (1 + np.exp(-design @ beta))
        gradient = design.T @ (weights * (correct - p))
        hessian = (design * (weights * p * (1 - p))[:, None]).T @ design
        beta = beta + np.linalg.solve(hessian, gradient)
    return beta


def gather(runs: list[Run]) -> tuple[Floats, NDArray[np.bool_], Floats, Floats]:
    """Return distances, whether the box was right, weights and confidences of all frames."""
    weights = np.concatenate([np.full(run.lost.size, 1 / run.lost.size) for run in runs])
    overlaps = np.nan_to_num(np.concatenate([run.overlaps for run in runs]))
    distances = np.concatenate([run.distances for run in runs])
    return distances, overlaps > 0.5, weights, np.concatenate([run.confidence for run in runs])


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
        for preset in options.presets:
            jobs = [(preset, folder, seed) for folder in folders for seed in range(options.seeds)]
            runs = list(pool.map(follow, *zip(*jobs, strict=True), chunksize=options.seeds))
            named = list(zip((folder for _, folder, _ in jobs), runs, strict=True))
            distances, correct, weights, confidence = gather(runs)
            beta = fit(distances, correct, weights)
            left_out = []
            for folder in folders:
                seen = gather([run for name, run in named if name != folder])
                held, *_ = gather([run for name, run in named if name == folder])
                b = fit(*seen[:3])
                left_out.append(1 / (1 + np.exp(-(b[0] + b[1] * held))))
            error = calibration_error(np.concatenate(left_out), correct, weights)
            shipped = calibration_error(confidence, correct, weights)
            print(
                f"| {preset} | {-beta[0] / beta[1]:.3f} | {-1 / beta[1]:.3f} "
                f"| {error:.3f} | {shipped:.3f} |",
                flush=True,
            )


if __name__ == "__main__":
    main()
