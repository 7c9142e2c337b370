"""Follow a target that turns once around itself, and compare the angle with the truth.

    python benchmarks/rotation.py [--seeds 5] [--clips 3] [PRESET ...]

The ellipse of `motes.synthetic.turning` in several sceneries, 3.6 degrees a frame; the error is
taken modulo half a turn, after which an ellipse is the same. Means and standard deviations over
sceneries and seeds; a run follows the full turn if its error never reaches 45 degrees.
"""

from __future__ import annotations

import argparse

import numpy as np
from numpy.typing import NDArray

from motes import PRESETS, Tracker, synthetic


def errors(preset: str, clip: synthetic.Clip, seed: int) -> NDArray[np.float64]:
    """Return the angle's error in degrees, frame by frame, from 0 to 90."""
    tracker = Tracker(preset, seed)
    off = []
    for index, (frame, (target,)) in enumerate(clip):
        track = tracker.update(frame) if index else tracker.init(frame, target.ellipse)
        off.append(track.ellipse.theta - target.ellipse.theta)
    wrapped: NDArray[np.float64] = np.abs((np.degrees(off) + 90) % 180 - 90)
    return wrapped


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    presets = [name for name in PRESETS if name.startswith("maggio")]
    parser.add_argument("presets", nargs="*", default=presets)
    parser.add_argument("--seeds", type=int, default=5)
    parser.add_argument("--clips", type=int, default=3)
    options = parser.parse_args()
    clips = [synthetic.turning(seed=seed) for seed in range(options.clips)]
    print("| tracker | mean error | largest error | full turns followed |")
    print("|---|---|---|---|")
    for preset in options.presets:
        runs = [errors(preset, clip, seed) for clip in clips for seed in range(options.seeds)]
        mean = [run.mean() for run in runs]
        largest = [run.max() for run in runs]
        followed = sum(value < 45 for value in largest)
        print(
            f"| {preset} | {np.mean(mean):.1f}° ± {np.std(mean):.1f}° "
            f"| {np.mean(largest):.0f}° ± {np.std(largest):.0f}° | {followed} of {len(runs)} |",
            flush=True,
        )


if __name__ == "__main__":
    main()
