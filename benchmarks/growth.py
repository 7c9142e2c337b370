"""Follow a target that grows fourfold and shrinks back, with and without scale selection.

    python benchmarks/growth.py [--seeds 5] [--clips 3] [PRESET ...]

The ellipse of `motes.synthetic.growing` in several sceneries; mean and standard deviation of the
mean OD (Maggio et al., equation 11) over sceneries and seeds; then how far the orientation
histogram of the true region is from the model at four times the first size, with and without.
"""

from __future__ import annotations

import argparse

import numpy as np

from motes import Frame, Tracker, synthetic
from motes.cues.orientation import Orientation
from motes.evaluate.metrics import overlap_distances

PRESETS = ["maggio:C", "maggio", "maggio:C+O-A-ROH", "maggio:C+O-A&SS-FOH", "maggio:C+O-A-FOH"]


def grown(cue: Orientation, clip: list[tuple[Frame, tuple[synthetic.Truth, ...]]]) -> float:
    """Return the distance of the largest true region to the model, which has seen all before."""
    model = cue.learn(clip[0][0], clip[0][1][0].ellipse)
    largest = max(range(len(clip)), key=lambda index: clip[index][1][0].ellipse.area)
    for frame, (target,) in clip[:largest]:
        model = cue.settle(model, frame, target.ellipse)
    frame, (target,) = clip[largest]
    return float(cue.distances(model, frame, np.array([target.ellipse]))[0])


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("presets", nargs="*", default=PRESETS)
    parser.add_argument("--seeds", type=int, default=5)
    parser.add_argument("--clips", type=int, default=3)
    options = parser.parse_args()
    clips = [list(synthetic.growing(seed=seed)) for seed in range(options.clips)]
    print("| tracker | mean OD |")
    print("|---|---|")
    for preset in options.presets:
        runs = []
        for clip in clips:
            truth = np.array([target.ellipse for _, (target,) in clip])
            for seed in range(options.seeds):
                tracker = Tracker(preset, seed)
                tracks = [tracker.init(clip[0][0], clip[0][1][0].ellipse)]
                tracks += [tracker.update(frame) for frame, _ in clip[1:]]
                found = np.array([track.ellipse for track in tracks])
                runs.append(overlap_distances(found, truth).mean())
        print(f"| {preset} | {np.mean(runs):.3f} ± {np.std(runs):.3f} |", flush=True)
    print()
    for selection in (True, False):
        cue = Orientation(scale_selection=selection)
        distances = [grown(cue, clip) for clip in clips]
        print(f"scale_selection={selection}: {np.mean(distances):.3f} ± {np.std(distances):.3f}")


if __name__ == "__main__":
    main()
