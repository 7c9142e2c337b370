"""Follow a target whose regions of consecutive frames do not overlap.

    python benchmarks/leaps.py [--seeds 5] [--clips 3] [PRESET ...]

The target of `motes.synthetic.jumping` in several sceneries; mean and standard deviation over
sceneries and seeds. A leap frame is one whose true box does not overlap the one before.
"""

from __future__ import annotations

import argparse

import numpy as np

from motes import PRESETS, Tracker, synthetic
from motes.geometry import iou


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("presets", nargs="*", default=list(PRESETS))
    parser.add_argument("--seeds", type=int, default=5)
    parser.add_argument("--clips", type=int, default=3)
    options = parser.parse_args()
    clips = [list(synthetic.jumping(seed=seed)) for seed in range(options.clips)]
    print("| tracker | mean IoU | frames on target (IoU > 0.1) | leap frames on target |")
    print("|---|---|---|---|")
    for preset in options.presets:
        runs = []
        for clip in clips:
            truth = np.array([target.ellipse.box for _, (target,) in clip])
            leap = np.append(False, iou(truth[1:], truth[:-1]) == 0)
            for seed in range(options.seeds):
                tracker = Tracker(preset, seed)
                tracks = [tracker.init(clip[0][0], truth[0].tolist())]
                tracks += [tracker.update(frame) for frame, _ in clip[1:]]
                overlap = iou(np.array([track.box for track in tracks]), truth)
                on = overlap > 0.1
                runs.append((overlap.mean(), on.mean(), on[leap].mean()))
        mean, deviation = np.mean(runs, axis=0), np.std(runs, axis=0)
        print(
            f"| {preset} | {mean[0]:.2f} ± {deviation[0]:.2f} | {mean[1]:.0%} | {mean[2]:.0%} |",
            flush=True,
        )


if __name__ == "__main__":
    main()
