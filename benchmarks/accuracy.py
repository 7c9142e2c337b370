"""Success AUC, lost status and confidence of the presets on real sequences.

    python benchmarks/accuracy.py [--seeds 5] [--data FOLDER] [PRESET ...]

FOLDER holds sequences in OTB's layout (`NAME/img/`, `NAME/groundtruth_rect.txt`; names that begin
with seg- are 0-based); the default is $MOTES_DATA/sot or ../shared/data/sot. Prints tables in
Markdown: a row a sequence, mean and standard deviation over seeds.
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

from motes import PRESETS, Frame, Status, Tracker, open_source
from motes.evaluate.metrics import calibration_error, detection_f1, success_auc
from motes.evaluate.sequences import Sequence, load_dataset
from motes.geometry import iou

HERE = Path(__file__).resolve().parent
DATA = Path(os.environ.get("MOTES_DATA", HERE.parent.parent / "shared" / "data")) / "sot"
MAIN = [
    *["Couple", "Crossing", "David", "Diving", "Dog1", "DragonBaby", "FaceOcc1"],
    *["Football1", "Girl", "Jogging-1", "Skiing", "Bird2", "Surfer"],
]


@dataclass(frozen=True)
class Run:
    """One tracker on one sequence with one seed, frame by frame."""

    overlaps: NDArray[np.float64]
    confidence: NDArray[np.float64]
    lost: NDArray[np.bool_]
    distances: NDArray[np.float64]


@cache
def load(folder: Path) -> tuple[Sequence, list[Frame]]:
    first_pixel = {"*": 0} if folder.name.startswith("seg-") else {}
    sequences, problems = load_dataset(folder, first_pixel)
    assert not problems, problems
    sequence = sequences[0]
    with open_source(sequence.source) as source:
        return sequence, list(source)


def follow(preset: str, folder: Path, seed: int) -> Run:
    sequence, frames = load(folder)
    tracker = Tracker(preset, seed)
    tracks = [tracker.init(frames[0], sequence.boxes[0].tolist())]
    tracks += [tracker.update(frame) for frame in frames[1:]]
    overlaps = iou(np.array([track.box for track in tracks]), np.nan_to_num(sequence.boxes))
    there = np.isfinite(sequence.boxes).all(axis=1)
    return Run(
        np.where(there, overlaps, np.nan),
        np.array([track.confidence for track in tracks]),
        np.array([track.status is not Status.TRACKING for track in tracks]),
        np.array([track.distance for track in tracks]),
    )


def auc(run: Run) -> float:
    return success_auc(run.overlaps[np.isfinite(run.overlaps)])


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("presets", nargs="*", default=list(PRESETS))
    parser.add_argument("--seeds", type=int, default=5)
    parser.add_argument("--data", type=Path, default=DATA)
    options = parser.parse_args()
    present = sorted(path.parent.name for path in options.data.glob("*/groundtruth_rect.txt"))
    if not present:
        parser.error(f"no sequences in {options.data}; name a folder with --data")
    names = [n for n in MAIN if n in present] + [n for n in present if n not in MAIN]
    # Sequence by sequence, so that each is decoded once and forgotten.
    jobs = [
        (p, options.data / n, s)
        for n in names
        for p in options.presets
        for s in range(options.seeds)
    ]
    with ProcessPoolExecutor(os.cpu_count()) as pool:
        results = dict(
            zip(jobs, pool.map(follow, *zip(*jobs, strict=True), chunksize=5), strict=True)
        )
    table(options, names, results)


def table(
    options: argparse.Namespace, names: list[str], results: dict[tuple[str, Path, int], Run]
) -> None:
    def runs(preset: str, name: str) -> list[Run]:
        return [results[preset, options.data / name, seed] for seed in range(options.seeds)]

    print("| sequence | " + " | ".join(options.presets) + " |")
    print("|---" * (len(options.presets) + 1) + "|")
    for name in names:
        cells = [[auc(run) for run in runs(preset, name)] for preset in options.presets]
        print(
            f"| {name} | " + " | ".join(f"{np.mean(c):.3f} ± {np.std(c):.3f}" for c in cells) + " |"
        )
    for label, group in (("13 OTB", MAIN), ("all", names)):
        group = [name for name in group if name in names]
        means = []
        for preset in options.presets:
            aucs = np.array([[auc(run) for run in runs(preset, name)] for name in group])
            per_seed = aucs.mean(axis=0)
            means.append(f"**{per_seed.mean():.3f} ± {per_seed.std():.3f}**")
        print(f"| mean of {label} ({len(group)}) | " + " | ".join(means) + " |")
    print()
    print("| over all sequences | " + " | ".join(options.presets) + " |")
    print("|---" * (len(options.presets) + 1) + "|")
    rows: dict[str, list[str]] = {"F1 of lost (IoU < 0.1)": [], "frames called lost": [], "ECE": []}
    for preset in options.presets:
        every = [run for name in names for run in runs(preset, name)]
        lost = np.concatenate([run.lost for run in every])
        overlaps = np.nan_to_num(np.concatenate([run.overlaps for run in every]))
        weights = np.concatenate([np.full(run.lost.size, 1 / run.lost.size) for run in every])
        confidence = np.concatenate([run.confidence for run in every])
        rows["F1 of lost (IoU < 0.1)"].append(f"{detection_f1(lost, overlaps < 0.1):.2f}")
        rows["frames called lost"].append(f"{lost.mean():.2f}")
        rows["ECE"].append(f"{calibration_error(confidence, overlaps > 0.5, weights):.3f}")
    for label, values in rows.items():
        print(f"| {label} | " + " | ".join(values) + " |")


if __name__ == "__main__":
    main()
