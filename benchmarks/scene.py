"""How many frames a second a scene of many objects takes, and what of it is detection.

    python benchmarks/scene.py

Twenty rendered targets at 640x480 that circle around their places. They are detected from the
truth, so that all of them are there; the time of detection is that of `BackgroundDetector`, on the
same frames. Times are the processor's, those of all threads together, so that they do not depend on
what else runs; frames/s are those of one core.
"""

from __future__ import annotations

import time

import numpy as np

from motes import synthetic
from motes.background import BackgroundDetector
from motes.detection import Detection
from motes.frame import Frame
from motes.scene import Scene

SIZE, TARGET, OBJECTS = (640, 480), (60, 80), 20
LAPS = 10
WARM = 20
"""Frames before any is timed: births, and compiling."""


def main() -> None:
    """Print a table."""
    clip = synthetic.crowd(SIZE, TARGET)
    assert len(clip.targets) == OBJECTS
    pictures = [
        (frame.pixels, [Detection(truth.ellipse.box) for truth in truths]) for frame, truths in clip
    ]
    found: list[Detection] = []
    scene, background = Scene(lambda _: found), BackgroundDetector()
    detection, tracking, index = [], [], 0
    for _ in range(LAPS):
        for pixels, detections in pictures:
            found[:] = detections
            start = time.process_time()
            background(Frame(index, index / 25, pixels))
            between = time.process_time()
            said = scene.update(Frame(index, index / 25, pixels))
            detection.append(between - start)
            tracking.append(time.process_time() - between)
            index += 1
    assert len(said) == OBJECTS
    both = np.add(detection, tracking)
    print("| part | ms of processor, median | ms, 95 % within | frames/s |")
    print("|---|---|---|---|")
    for name, times in {"detection": detection, "tracking": tracking, "both": both}.items():
        middle, high = np.quantile(times[WARM:], (0.5, 0.95)) * 1000
        print(f"| {name} | {middle:.1f} | {high:.1f} | {1000 / middle:.0f} |")


if __name__ == "__main__":
    main()
