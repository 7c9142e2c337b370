"""The truth of OTB, `groundtruth_rect.txt`: a box for each frame from the first one on.

A line is x,y,width,height; pixels count from 1. Wu, Lim and Yang, Object tracking benchmark, PAMI
2015. A frame without the target has a box without size, as in the later sequences.
"""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

from motes.core.files import check_ended
from motes.core.track import Status
from motes.formats.recording import FilmFacts, Recording, recording_of, sound
from motes.formats.regions import ABSENT, read_regions
from motes.formats.text import read_text
from motes.formats.visibility import only_object
from motes.rows.journal import ObjectRow

FIRST_PIXEL = 1


def write(recorded: Recording) -> Iterator[bytes]:
    """Yield a line for each frame; raise a FormatError if there are several objects."""
    here = only_object(recorded, "OTB")
    for frame in range(frame_count(recorded)):
        if frame in here:
            x, y, width, height = here[frame].box
            box = f"{x + FIRST_PIXEL:.2f},{y + FIRST_PIXEL:.2f},{width:.2f},{height:.2f}"
        else:
            box = "0,0,0,0"
        yield box.encode() + b"\n"


def frame_count(recorded: Recording) -> int:
    """Return the number of frames up to the last one of a recording."""
    return max((row.frame for row in recorded), default=-1) + 1


def read(path: Path, facts: FilmFacts) -> Recording:
    """Return the target of a truth of OTB."""
    return read_frames(path, facts, FIRST_PIXEL)


def read_frames(path: Path, facts: FilmFacts, first_pixel: int) -> Recording:
    """Return the target of a text for `read_regions` in which pixels count from a number."""
    text = read_text(path)
    check_ended(text)
    regions = read_regions(text, strict=True)
    objects = []
    for frame, region in enumerate(regions):
        if region is not ABSENT:
            ellipse = region.ellipse
            ellipse = ellipse._replace(x=ellipse.x - first_pixel, y=ellipse.y - first_pixel)
            objects.append((frame, sound(ObjectRow(1, ellipse, 1.0, Status.TRACKING))))
    return recording_of(facts, objects, dict.fromkeys(range(len(regions))))
