"""The acceleration of thrown balls on rendered films, by a parabola through their places.

    python benchmarks/throws.py [--films 24]

Each film is one of docs/tutorials/measure.md, with another ball, throw and background. The ball is
marked in its first frame, once exactly and once with a box that is shifted and sized up to a tenth
wrong.
"""

from __future__ import annotations

import argparse
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

import motes
from motes.core.geometry import Box
from motes.core.types import Floats
from motes.synthetic import Clip, Target

GRAVITY, SCALE, RATE, PARTS = 9.81, 160, 30, 8
"""In m/s², pixels a metre, frames a second, moments in a frame, of which the shutter sees half."""
WIDTH, HEIGHT, FRAMES = 640, 480, 33


def render(path: Path, rng: np.random.Generator, seed: int) -> Box:
    """Write a film of a throw; return the box of the ball in its first frame."""
    radius, across, up = rng.uniform(12, 24), rng.uniform(1.5, 2.6), rng.uniform(4, 5.5)
    moments = np.arange(FRAMES * PARTS) / (RATE * PARTS)
    x = SCALE * (0.6 + across * moments)
    y = SCALE * (2 - up * moments + GRAVITY / 2 * moments**2)
    inside = (x < WIDTH - radius) & (y < HEIGHT - radius)
    count = len(x) if inside.all() else int(inside.argmin()) // PARTS * PARTS
    size = np.full_like(x, radius)
    states = np.stack([x, y, size, size, 0 * size], axis=1)[:count]
    red, green, blue = rng.integers(20, 250, 3).tolist()
    clip = Clip((WIDTH, HEIGHT), (Target(states, ((red, green, blue),) * 3),), seed=seed)
    with motes.VideoWriter(path, RATE) as writer:
        for first in range(0, count, PARTS):
            seen = [clip[first + part][0].pixels for part in range(PARTS // 2)]
            writer.write(np.mean(seen, axis=0).astype(np.uint8))
    return clip[0][1][0].ellipse.box


def error(path: Path, box: Floats) -> float:
    """Return the error of the acceleration in percent, if the ball is marked by a box."""
    tracks = motes.correct(path, {0: tuple(box.tolist())})
    seen = [track for track in tracks if track.status is motes.Status.TRACKING]
    times = [track.time for track in seen]
    metres = [track.ellipse.y / SCALE for track in seen]
    return float(100 * (2 * np.polyfit(times, metres, 2)[0] / GRAVITY - 1))


def main() -> None:
    """Print the errors of all films."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--films", type=int, default=24)
    errors: dict[str, list[float]] = {"exact": [], "a tenth wrong": []}
    for seed in range(parser.parse_args().films):
        rng = np.random.default_rng(seed)
        with TemporaryDirectory() as folder:
            path = Path(folder, "throw.mp4")
            box = np.array(render(path, rng, seed))
            wrong = rng.uniform(-0.1, 0.1, 3)[[0, 1, 2, 2]] * box[2]
            for name, marked in (("exact", box), ("a tenth wrong", box + wrong)):
                errors[name].append(error(path, marked))
    for name, found in errors.items():
        off = np.abs(found)
        print(f"{name:14} median {np.median(off):.2f} %, largest {off.max():.2f} %")


if __name__ == "__main__":
    main()
