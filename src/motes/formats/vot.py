"""The truth of VOT, `groundtruth.txt`: a region for each frame from the first one on.

A line is a box x,y,width,height, or the four corners of a rotated one; pixels count from 0. A frame
without the target has NaN. Kristan et al., A novel performance evaluation methodology for
single-target trackers, PAMI 2016.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from pathlib import Path

from motes.core.geometry import Ellipse
from motes.formats.otb import frame_count, read_frames
from motes.formats.recording import FilmFacts, Recording
from motes.formats.visibility import only_object

FIRST_PIXEL = 0
ABSENT = "nan,nan,nan,nan"


def write(recorded: Recording) -> Iterator[bytes]:
    """Yield a line for each frame; raise a FormatError if there are several objects."""
    here = only_object(recorded, "VOT")
    for frame in range(frame_count(recorded)):
        yield (_region(here[frame].ellipse) if frame in here else ABSENT).encode() + b"\n"


def _region(ellipse: Ellipse) -> str:
    if not ellipse.theta:
        return ",".join(f"{value:.4f}" for value in ellipse.box)
    x, y, a, b, theta = ellipse
    cos, sin = math.cos(theta), math.sin(theta)
    corners = [
        (x + 0.5 + u * a * cos - v * b * sin, y + 0.5 + u * a * sin + v * b * cos)
        for u, v in ((-1, -1), (1, -1), (1, 1), (-1, 1))
    ]
    return ",".join(f"{value:.4f}" for corner in corners for value in corner)


def read(path: Path, facts: FilmFacts) -> Recording:
    """Return the target of a truth of VOT; masks become ellipses."""
    return read_frames(path, facts, FIRST_PIXEL)
