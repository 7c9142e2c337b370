"""What each voice of the default tracker brings: mean overlaps with it and without it.

    python benchmarks/experts.py SEQUENCES [--only GLOB ...] [--first-pixel 'seg-*=0' ...]

The folder is followed forwards, and then backwards from its last box: the same films, and other
starts, occlusions and changes. The interval is that of paired differences over sequences.
"""

from __future__ import annotations

import argparse
from collections.abc import Mapping
from fnmatch import fnmatchcase
from itertools import islice
from pathlib import Path

import numpy as np

from motes.core.frame import Frame
from motes.core.geometry import Box, iou
from motes.core.types import Floats
from motes.sot.discriminative.expert import Confined, Evidence
from motes.sot.discriminative.tracker import Discriminative
from motes.sot.tracker import Tracker
from motes.video.sources import open_source
from motes_lab.datasets.sot import Sequence, load_dataset

LEAST_SIDE = 4
"""A run begins at the first box that has sides of so many pixels."""
PRIOR = Evidence().prior
VARIANTS: Mapping[str, Discriminative] = {
    "as shipped": Discriminative(),
    "without the confined filter": Discriminative(confined=Confined(weight=0.0)),
    # The prior moves by what the voice says half-way between a target and another place.
    "without the color contrast": Discriminative(
        evidence=Evidence(contrast=0.0, prior=PRIOR + 1.35)
    ),
    "without the first filter": Discriminative(evidence=Evidence(gradients=0.0, prior=PRIOR + 1.4)),
}


def overlap(config: Discriminative, frames: list[Frame], boxes: Floats) -> float:
    """Return the mean overlap of a track that begins at the first of boxes (frames, 4)."""
    tracker = Tracker(config, seed=0)
    tracker.init(frames[0].pixels, Box(*boxes[0]))
    found = []
    for frame, box in zip(frames[1:], boxes[1:], strict=True):
        track = tracker.update(frame.pixels)
        if np.isfinite(box).all():
            found.append(float(iou(track.box, Box(*box))))
    return float(np.mean(found))


def overlaps(sequence: Sequence, limit: int, *, backward: bool) -> list[float]:
    """Return the mean overlap of each variant in a sequence."""
    with open_source(sequence.source) as source:
        frames = list(islice(source, min(limit, sequence.frames)))
    boxes = sequence.boxes[: len(frames)]
    if backward:
        frames, boxes = frames[::-1], boxes[::-1]
    start = int(np.argmax(np.nan_to_num(boxes[:, 2:]).min(axis=1) >= LEAST_SIDE))
    frames, boxes = frames[start:], boxes[start:]
    return [overlap(config, frames, boxes) for config in VARIANTS.values()]


def differences(rows: Floats) -> list[str]:
    """Return the mean of each variant, and its difference to the first; rows (sequences, n)."""
    changes = rows - rows[:, :1]
    halves = 1.96 * changes.std(axis=0, ddof=1) / np.sqrt(len(rows))
    return [
        f"{mean:.3f} | {change:+.3f} ± {half:.3f}"
        for mean, change, half in zip(rows.mean(0), changes.mean(0), halves, strict=True)
    ]


def main() -> None:
    """Print a table of the voices, forwards and backwards."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("sequences", type=Path)
    parser.add_argument("--only", nargs="*", default=["*"])
    parser.add_argument("--first-pixel", nargs="*", default=[])
    parser.add_argument("--frames", type=int, default=300)
    options = parser.parse_args()
    first = {glob: int(pixel) for glob, pixel in (v.rsplit("=", 1) for v in options.first_pixel)}
    sequences, problems = load_dataset(options.sequences, first)
    assert not problems, problems
    sequences = [s for s in sequences if any(fnmatchcase(s.name, glob) for glob in options.only)]
    print(f"### What each voice brings: {len(sequences)} sequences\n")
    print("| tracker | forwards | difference | backwards | difference |")
    print("| --- | --- | --- | --- | --- |")
    cells = [
        differences(np.array([overlaps(s, options.frames, backward=way) for s in sequences]))
        for way in (False, True)
    ]
    for name, there, back in zip(VARIANTS, *cells, strict=True):
        print(f"| {name} | {there} | {back} |")


if __name__ == "__main__":
    main()
