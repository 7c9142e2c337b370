"""Errors of the angle on real pictures that are turned: Maggio et al., section 3.2.1.

    python benchmarks/turned_pictures.py SEQUENCE ...

The first picture of each sequence turns once around its target, in 100 frames. So the angle is
known, which no film at hand has.
"""

from __future__ import annotations

import sys
from collections.abc import Sequence
from pathlib import Path

import numpy as np
from PIL import Image

from motes import Tracker
from motes.core.frame import FRAME_INTERVAL, Frame
from motes.core.geometry import Ellipse
from motes.core.types import Floats
from motes.video.sources import open_source
from motes_lab.adapters.registry import motes_config
from motes_lab.datasets.sot import load_dataset
from motes_lab.metrics.statistics import over
from motes_lab.report import markdown
from motes_lab.report.tables import Cell, Row, Table, number

PRESETS = (
    "maggio", "maggio:C", "lab/docs/variants/maggio-orientation-fourier.toml", "maggio:O-ROH"
)  # fmt: skip
FRAMES = 100
FOLLOWED = 45.0
"""Degrees; a tracker has followed the whole turn if its error is always smaller."""


def first_of(folder: Path) -> tuple[Image.Image, Ellipse]:
    """Return the first picture of a sequence, and the target in it."""
    [film, *_], _ = load_dataset(folder)
    with open_source(film.source) as frames:
        return Image.fromarray(next(iter(frames)).pixels), Ellipse(*film.ellipses[0])


def errors(preset: str, picture: Image.Image, target: Ellipse) -> Floats:
    """Return the errors of a tracker's angle (frames,) in degrees, modulo half a turn."""
    tracker, off = Tracker(motes_config(preset), 0), np.empty(FRAMES)
    for index in range(FRAMES):
        angle = 360 * index / FRAMES
        turned = picture.rotate(-angle, Image.Resampling.BICUBIC, center=(target.x, target.y))
        frame = Frame(index, index * FRAME_INTERVAL, np.array(turned))
        track = tracker.update(frame) if index else tracker.init(frame, target)
        off[index] = np.degrees(long_axis(track.ellipse) - long_axis(target)) - angle
    return np.abs((off + 90) % 180 - 90)


def long_axis(ellipse: Ellipse) -> float:
    """Return the angle of the long axis: a motion model may swap the half-axes."""
    return ellipse.theta + (np.pi / 2 if ellipse.b > ellipse.a else 0.0)


def main(sequences: Sequence[str]) -> int:
    """Print the table."""
    pictures = [first_of(Path(each)) for each in sequences]
    rows: list[Row] = []
    for preset in PRESETS:
        found = [errors(preset, *each) for each in pictures]
        followed = sum(each.max() < FOLLOWED for each in found)
        means = number(over(each.mean() for each in found), 1)
        rows.append((Cell(preset), means, Cell(f"{followed} of {len(found)}")))
    head = ("tracker", "mean error (degrees)", "turns followed")
    note = f"Over pictures, one seed. Followed: the error never reaches {FOLLOWED:g} degrees."
    print(markdown.table(Table("Pictures that turn once", head, rows, note=note)))
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
