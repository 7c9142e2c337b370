"""The error and the 95 % ellipse of tracks, before and after both ways are joined and smoothed.

    python benchmarks/both_ways.py                      rendered clips
    python benchmarks/both_ways.py DATASET --gap 40     sequences, with the box of every 40th frame
    python benchmarks/both_ways.py DATASET --gap 0      one pass from the first frame, smoothed

Before: the preset, started anew at each keyframe. After: passes in both directions between the same
keyframes, joined and smoothed. The first and last frame of each stretch are left out, as they are
marked. Errors of the center are in mean sides of the target, and count as 1 at most.
"""

from __future__ import annotations

import argparse
import itertools
import sys
from collections.abc import Iterator, Sequence
from pathlib import Path

import numpy as np

from motes import synthetic
from motes.core.errors import MotesError
from motes.core.frame import Frame
from motes.core.geometry import Ellipse, iou
from motes.core.track import Track
from motes.core.types import Floats
from motes.correction.correct import passes_over, smooth
from motes.correction.join import Stretch, enclosing
from motes.correction.passes import run_pass
from motes.sot.presets import preset
from motes.synthetic.clips import Clip
from motes.video.film import Film, FrameReader
from motes_lab.datasets.sot import load_dataset
from motes_lab.metrics.sot import CHI_SQUARE_95
from motes_lab.report import markdown
from motes_lab.report.tables import Cell, Row, Table, number

RENDERED = ("turning", "growing", "occluded", "rolling", "jumping")


class Rendered:
    """The frames of a rendered clip, in any order."""

    def __init__(self, clip: Clip) -> None:
        self._clip = clip

    def forward(self, first: int, last: int) -> Iterator[Frame]:
        """Yield the frames from `first` to `last`."""
        return (self._clip[i][0] for i in range(first, last + 1))

    def backward(self, last: int, first: int) -> Iterator[Frame]:
        """Yield the frames from `last` down to `first`."""
        return (self._clip[i][0] for i in range(last, first - 1, -1))


def films(
    dataset: Path | None, longest: int, first_pixel: int | None
) -> Iterator[tuple[str, FrameReader, Floats]]:
    """Yield the name, the frames and the true boxes of each film."""
    if dataset is None:
        for name in RENDERED:
            clip = getattr(synthetic, name)((320, 240))
            boxes = np.array([clip[i][1][0].ellipse.box for i in range(len(clip))])
            yield name, Rendered(clip), boxes
        return
    pixels = {} if first_pixel is None else {"*": first_pixel}
    for sequence in load_dataset(dataset, pixels)[0]:
        if sequence.frames <= longest:
            yield sequence.name, Film(sequence.source), sequence.boxes


def stretch_numbers(
    reader: FrameReader, boxes: Floats, first: int, last: int, name: str, seed: int
) -> Floats:
    """Return, for each frame: overlap, error and hit of the 95 % ellipse, before and after."""
    begin, end = Ellipse.from_box(boxes[first]), Ellipse.from_box(boxes[last])
    config = preset(name)
    ahead = run_pass(config, seed, reader.forward(first, last), begin)
    stretch = Stretch(first, last, begin, end)
    joined = stretch.course(*passes_over(reader, stretch, config, seed))
    after = np.array([np.diag(row) for row in joined.variances[:, :2]])
    return compared(ahead, (joined.ellipses, after), boxes[first : last + 1])[1:-1]


def one_pass_numbers(
    reader: FrameReader, boxes: Floats, first: int, last: int, name: str, seed: int
) -> Floats:
    """Return the same numbers of one pass, before and after `smooth`."""
    frames = reader.forward(first, last)
    ahead = run_pass(preset(name), seed, frames, Ellipse.from_box(boxes[first]))
    return compared(ahead, regions(smooth(ahead)), boxes[first : last + 1])[1:]


def regions(tracks: Sequence[Track]) -> tuple[Floats, Floats]:
    """Return the ellipses (n, 5) of tracks, and the covariances of their centers (n, 2, 2)."""
    covariances = np.array([track.covariance[:2, :2] for track in tracks])
    return np.array([track.ellipse for track in tracks]), covariances


def compared(ahead: Sequence[Track], after: tuple[Floats, Floats], truth: Floats) -> Floats:
    """Return the numbers (n, 6) of a pass, and of what became of it."""
    centers = truth[:, :2] + (truth[:, 2:] - 1) / 2
    sides = np.sqrt(truth[:, 2:].prod(axis=1))
    columns = []
    for ellipses, spread in (regions(ahead), after):
        offsets = ellipses[:, :2] - centers
        inverse = np.linalg.inv(spread + 1e-9 * np.eye(2))
        hits = np.einsum("ni,nij,nj->n", offsets, inverse, offsets) <= CHI_SQUARE_95
        errors = np.minimum(np.hypot(*offsets.T) / sides, 1)
        columns += [iou(enclosing(ellipses), truth), errors, hits]
    return np.stack(columns, axis=1)


def main() -> None:
    """Print the means over films, and a table with a row for each."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("dataset", nargs="?", type=Path)
    parser.add_argument("--gap", type=int, default=40, help="frames between keyframes; 0: one")
    parser.add_argument("--longest", type=int, default=10**9, help="frames of a sequence at most")
    parser.add_argument("--first-pixel", type=int, help="as for motes-lab evaluate")
    parser.add_argument("--preset", default="default")
    parser.add_argument("--seed", type=int, default=0)
    options = parser.parse_args()
    means = list[Floats]()
    rows: list[Row] = []
    for name, reader, boxes in films(options.dataset, options.longest, options.first_pixel):
        present = np.flatnonzero(np.isfinite(boxes).all(axis=1))
        measure = stretch_numbers if options.gap else one_pass_numbers
        keys = [*present[:: options.gap or len(boxes)].tolist()]
        if keys[-1] != present[-1]:
            keys.append(int(present[-1]))
        found = list[Floats]()
        for first, last in itertools.pairwise(keys):
            try:
                found.append(measure(reader, boxes, first, last, options.preset, options.seed))
            except MotesError as error:
                print(f"{name}, frames {first} to {last}: {error}", file=sys.stderr)
        numbers = np.concatenate(found)
        numbers = numbers[np.isfinite(numbers).all(axis=1)]
        right = (numbers[:, [0, 3]] >= 0.7).mean(axis=0)
        values = np.array([*right, *numbers[:, [1, 4, 2, 5]].mean(axis=0)])
        means.append(values)
        rows.append((Cell(name), *map(number, values.tolist())))
    where = "rendered clips" if options.dataset is None else options.dataset.name
    how = f"every {options.gap} frames" if options.gap else "one pass"
    mean = Cell(f"{len(rows)} of {where}, {how}"), *map(number, np.mean(means, axis=0).tolist())
    head = (
        *("films", "IoU ≥ 0.7", "after", "error of the center", "after"),
        *("truth in the 95 % ellipse", "after"),
    )
    for title, lines in (("Both ways, means over films", [mean]), ("Both ways, each film", rows)):
        print(markdown.table(Table(title, head, lines)), end="\n\n")


if __name__ == "__main__":
    main()
