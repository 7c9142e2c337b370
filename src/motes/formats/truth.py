"""The truth of one target: of OTB, `groundtruth_rect.txt`, and of others, `groundtruth.txt`.

There is a line for each frame from the first one on. OTB's is a box x,y,width,height; pixels count
from 1, and a frame without the target has a box without size, as in the later sequences. Wu, Lim
and Yang, Object tracking benchmark, PAMI 2015. VOT's is such a box, or the four corners of a
rotated one; pixels count from 0, and a frame without the target has NaN. Kristan et al., A novel
performance evaluation methodology for single-target trackers, PAMI 2016. motes writes corners
alone, as boxes do not tell the first pixel.

LaSOT's and GOT-10k's are boxes whose pixels count from 1; files beside them mark the frames without
the target. Fan et al., LaSOT, CVPR 2019; Huang, Zhao and Huang, GOT-10k, PAMI 2021.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Literal

from motes.core.errors import FormatError, counted
from motes.core.files import check_ended, lines_of, read_text
from motes.core.geometry import Box, Ellipse
from motes.core.track import Track
from motes.formats.recording import FilmFacts, Recording, placed, sound
from motes.formats.truth_regions import ABSENT, UNKNOWN, read_regions

Kind = Literal["otb", "vot", "lasot", "got10k"]

FIRST_PIXEL = {"otb": 1, "vot": 0, "lasot": 1, "got10k": 1}
ABSENCES: dict[str, Sequence[str]] = {
    "lasot": ("full_occlusion.txt", "out_of_view.txt"), "got10k": ("absence.label",),
}  # fmt: skip
"""Files beside the truth with a 1 for each frame in which the target cannot be seen."""
MARKS: dict[Kind, Sequence[str]] = {
    "lasot": ABSENCES["lasot"],
    "got10k": ("absence.label", "meta_info.ini", "cover.label", "cut_by_image.label"),
    "vot": ("color", "sequence", "camera_motion.tag", "camera_motion.label"),
}
"""What lies beside a `groundtruth.txt` of each dataset."""
NOWHERE = {"otb": "0,0,0,0", "vot": "nan,nan,nan,nan"}


def write(kind: Kind, recorded: Recording) -> Iterator[bytes]:
    """Yield a line for each frame; raise a FormatError if there are several objects."""
    here = recorded.only_object(kind.upper())
    last = max((row.frame for row in recorded), default=-1)
    for frame in range(max(last + 1, recorded.length)):
        line = _line(kind, here[frame]) if frame in here else NOWHERE[kind]
        yield line.encode() + b"\n"


def _line(kind: Kind, each: Track) -> str:
    if kind == "otb":
        x, y, width, height = each.box
        return f"{x + 1:.2f},{y + 1:.2f},{width:.2f},{height:.2f}"
    x, y, a, b, theta = each.ellipse
    cos, sin = math.cos(theta), math.sin(theta)
    corners = [
        (x + 0.5 + u * a * cos - v * b * sin, y + 0.5 + u * a * sin + v * b * cos)
        for u, v in ((-1, -1), (1, -1), (1, 1), (-1, 1))
    ]
    return ",".join(f"{value:.4f}" for corner in corners for value in corner)


def kind_of(path: Path) -> Kind | None:
    """Return the dataset of a `groundtruth.txt` by what lies beside it; None without a mark."""
    found = (
        kind for kind, marks in MARKS.items() if any((path.parent / m).exists() for m in marks)
    )
    return next(found, None)


def absences(kind: str, folder: Path, count: int) -> list[bool]:
    """Return whether each frame of a truth is marked as one without the target.

    Raises a FormatError if a file of marks has another number of frames, or other words than 0 and
    1.
    """
    absent = [False] * count
    for name in ABSENCES.get(kind, ()):
        if (folder / name).is_file():
            words = read_text(folder / name, FormatError).replace(",", " ").split()
            if len(words) != count:
                raise FormatError(f"{name} is for {len(words)} frames, not {count}")
            if other := next((word for word in words if word not in ("0", "1")), None):
                raise FormatError(f"{name} has {other[:20]!r}, neither 0 nor 1")
            absent = [one or word == "1" for one, word in zip(absent, words, strict=True)]
    return absent


def read(kind: Kind, path: Path, facts: FilmFacts) -> Recording:
    """Return the target of a truth; masks become ellipses and boxes."""
    text = read_text(path, FormatError)
    check_ended(text)
    # Others have boxes of any size where the target is absent.
    regions, first = read_regions(text, strict=kind in ("otb", "vot")), FIRST_PIXEL[kind]
    if kind != "vot" and not all(region.is_box for region in regions):
        raise FormatError("a line has more than the four numbers of a box; of VOT, give --from vot")
    absent = absences(kind, path.parent, len(regions))
    objects = []
    for frame, region in enumerate(regions):
        if not (region is ABSENT or region is UNKNOWN or absent[frame]):
            x, y, *rest = region.ellipse
            ellipse = Ellipse(x - first, y - first, *rest)
            x, y, *sides = region.box
            bounds = Box(x - first, y - first, *sides)
            objects.append(sound(placed(frame, ellipse, bounds=bounds)))
    masks = sum(line.lstrip().startswith("m") for line in lines_of(text))
    left_out = [f"the pixels of {counted(masks, 'mask')}, but for box and ellipse"] * bool(masks)
    times = dict.fromkeys(range(len(regions)))
    unknown = [(frame, 1) for frame, region in enumerate(regions) if region is UNKNOWN]
    found = Recording.of(facts, objects, times, left_out=left_out, searched=unknown)
    return replace(found, single=True)
