"""The truth of one target: of OTB, `groundtruth_rect.txt`, and of VOT, `groundtruth.txt`.

There is a line for each frame from the first one on. OTB's is a box x,y,width,height; pixels count
from 1, and a frame without the target has a box without size, as in the later sequences. Wu, Lim
and Yang, Object tracking benchmark, PAMI 2015. VOT's is such a box, or the four corners of a
rotated one; pixels count from 0, and a frame without the target has NaN. Kristan et al., A novel
performance evaluation methodology for single-target trackers, PAMI 2016.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Literal

from motes.core.files import check_ended
from motes.core.geometry import Ellipse
from motes.core.track import Status
from motes.formats.recording import FilmFacts, Recording, recording_of, sound
from motes.formats.regions import ABSENT, read_regions
from motes.formats.text import read_text
from motes.formats.visibility import only_object
from motes.rows.journal import ObjectRow

Kind = Literal["otb", "vot"]

FIRST_PIXEL = {"otb": 1, "vot": 0}
NOWHERE = {"otb": "0,0,0,0", "vot": "nan,nan,nan,nan"}


def write(kind: Kind, recorded: Recording) -> Iterator[bytes]:
    """Yield a line for each frame; raise a FormatError if there are several objects."""
    here = only_object(recorded, kind.upper())
    last = max((row.frame for row in recorded), default=-1)
    for frame in range(max(last + 1, recorded.length)):
        line = _line(kind, here[frame]) if frame in here else NOWHERE[kind]
        yield line.encode() + b"\n"


def _line(kind: Kind, each: ObjectRow) -> str:
    if kind == "otb":
        x, y, width, height = each.box
        return f"{x + 1:.2f},{y + 1:.2f},{width:.2f},{height:.2f}"
    if not each.ellipse.theta:
        return ",".join(f"{value:.4f}" for value in each.ellipse.box)
    x, y, a, b, theta = each.ellipse
    cos, sin = math.cos(theta), math.sin(theta)
    corners = [
        (x + 0.5 + u * a * cos - v * b * sin, y + 0.5 + u * a * sin + v * b * cos)
        for u, v in ((-1, -1), (1, -1), (1, 1), (-1, 1))
    ]
    return ",".join(f"{value:.4f}" for corner in corners for value in corner)


def read(kind: Kind, path: Path, facts: FilmFacts) -> Recording:
    """Return the target of a truth; masks become ellipses."""
    text = read_text(path)
    check_ended(text)
    regions, first = read_regions(text, strict=True), FIRST_PIXEL[kind]
    objects = []
    for frame, region in enumerate(regions):
        if region is not ABSENT:
            x, y, *rest = region.ellipse
            ellipse = Ellipse(x - first, y - first, *rest)
            objects.append((frame, sound(ObjectRow(1, ellipse, 1.0, Status.TRACKING))))
    return replace(recording_of(facts, objects, dict.fromkeys(range(len(regions)))), single=True)
