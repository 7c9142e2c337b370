"""How much the reported ellipse of a rendered target at rest jitters under noise.

    python benchmarks/jitter.py [--preset default]

Standard deviations over 60 frames of 320x240, of the center in pixels and of the half-axes relative
to them. Four sceneries and targets of four sizes, noise of 4, 8 and 16 gray levels.
"""

from __future__ import annotations

import argparse

import numpy as np

from motes.core.frame import Frame
from motes.core.types import Floats
from motes.sot.tracker import Tracker
from motes.synthetic import still

SIZES = (20.0, 30.0), (30.0, 40.0), (40.0, 60.0), (60.0, 100.0)
NOISE = 4, 8, 16
FRAMES = 60


def jitter(preset: str, target: tuple[float, float], noise: float, seed: int) -> Floats:
    """Return the standard deviations of x, y, and of a and b relative to their means."""
    frame, (true, *_) = still((320, 240), target=target, frames=1, seed=seed)[0]
    rng, tracker, found = np.random.default_rng(seed), Tracker(preset, seed), []
    for index in range(FRAMES):
        noisy = np.clip(frame.pixels + rng.normal(0, noise, frame.pixels.shape), 0, 255)
        seen = Frame(index, index / 25, noisy.astype(np.uint8))
        track = tracker.update(seen) if index else tracker.init(seen, true.ellipse.box)
        found.append(track.ellipse[:4])
    spread: Floats = np.std(found, axis=0)
    spread[2:] /= np.mean(found, axis=0)[2:]
    return spread


def main() -> None:
    """Print a row for each noise: the least and the largest value over sceneries and sizes."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--preset", default="default")
    options = parser.parse_args()
    print("| noise, gray levels | x, pixels | y, pixels | a | b |\n|---|---|---|---|---|")
    for noise in NOISE:
        runs = [
            jitter(options.preset, target, noise, seed) for seed in range(4) for target in SIZES
        ]
        least, most = np.min(runs, axis=0), np.max(runs, axis=0)
        cells = [f"{low:.2f} to {high:.2f}" for low, high in zip(least[:2], most[:2], strict=True)]
        cells += [f"{low:.2%} to {high:.2%}" for low, high in zip(least[2:], most[2:], strict=True)]
        print(f"| {noise} | {' | '.join(cells)} |", flush=True)


if __name__ == "__main__":
    main()
