"""Boxes with identities in the format of the MOTChallenge: truth, detections and results.

A line is a box, its numbers separated by commas, semicolons, tabs or spaces:

    frame, id, x, y, width, height, score, class, visibility

Frames and pixels count from 1. Only truth has classes. The score of truth is a flag, 0 for boxes
that do not count. Milan et al., MOT16: a benchmark for multi-object tracking, 2016, table 4. Lines
of ten numbers have world coordinates instead of a class, as in Leal-Taixé et al., MOTChallenge
2015.
"""

from __future__ import annotations

import re
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from motes.core.errors import FormatError
from motes.core.files import check_ended
from motes.core.geometry import Box
from motes.core.types import Floats
from motes.formats.text import number, read_text

Integers = NDArray[np.int64]

Kind = Literal["truth", "results", "detections"]

CLASSES = range(1, 14)
"""Classes of objects in the truth; 1 is a pedestrian."""
UNKNOWN = -1
"""Class of a box that has none, and identity of a detection."""

AREAS: dict[Kind, str] = {"truth": "an object", "detections": "a detection"}
"""The kinds whose rows must have an area, and their names in the error."""

_NEEDED, _MOST = 7, 10
_SEPARATOR = re.compile(r"[ \t]*[,;][ \t]*|[ \t]+")


@dataclass(frozen=True, slots=True, eq=False)
class MotRows:
    """Boxes in the order of their frames.

    Attributes
    ----------
    frames, ids
        (n,), frames count from 1.
    boxes
        (n, 4): x, y, width, height; the first pixel is 1.
    scores
        (n,), confidences or, in the truth, flags.
    classes
        (n,), `UNKNOWN` where there is none.
    visibilities
        (n,), the visible part of each object, 0 to 1; 1 where it is not known.
    """

    frames: Integers
    ids: Integers
    boxes: Floats
    scores: Floats
    classes: Integers
    visibilities: Floats

    def at(self, frame: int) -> slice:
        """Return the slice of the rows of a frame, which counts from 1."""
        low, high = np.searchsorted(self.frames, [frame, frame + 1]).tolist()
        return slice(low, high)

    def listed(self, index: int) -> list[tuple[int, Box, float]]:
        """Return identity, box and score of the rows of a frame; frame and pixels count from 0."""
        rows = self.at(index + 1)
        boxes = (self.boxes[rows] - (1, 1, 0, 0)).tolist()
        columns = self.ids[rows].tolist(), boxes, self.scores[rows].tolist()
        return [(identity, Box(*box), score) for identity, box, score in zip(*columns, strict=True)]

    def where(self, chosen: NDArray[np.bool_]) -> MotRows:
        """Return the rows for which a mask (n,) is True."""
        return MotRows(
            self.frames[chosen],
            self.ids[chosen],
            self.boxes[chosen],
            self.scores[chosen],
            self.classes[chosen],
            self.visibilities[chosen],
        )


def rows_of(lines: list[list[float]]) -> MotRows:
    """Return rows from lists frame, id, x, y, width, height, score, class; frames in any order.

    Each list may end with the visibility.
    """
    table = np.array(lines, np.float64).reshape(len(lines), -1 if lines else _NEEDED + 1)
    table = table[np.argsort(table[:, 0], kind="stable")]
    frames, ids, classes = table[:, [0, 1, _NEEDED]].astype(np.int64).T
    visible = table[:, _NEEDED + 1] if table.shape[1] > _NEEDED + 1 else np.ones(len(table))
    return MotRows(frames, ids, table[:, 2:6], table[:, 6], classes, visible)


def read_rows(path: Path, frames: int, kind: Kind, *, sized: bool = False) -> MotRows:
    """Read the rows of a video, all of which have the same number of fields.

    Parameters
    ----------
    path
        The file; empty lines are skipped.
    frames
        Number of frames of the video.
    kind
        The content of the file. In truth and results, a frame has each identity at most once.
        Truth has classes and visibilities, and so have results of motes, which end with `1,-1`.
        Objects and detections must have an area; results need not.
    sized
        Whether results must have an area too.

    Raises
    ------
    OSError
        If it cannot be read.
    FormatError
        If it is not text, or a line is wrong, with file and line.
    """
    name = "/".join([path.parent.name, path.name]).lstrip("/")
    text = read_text(path)
    lines: list[list[float]] = []
    seen: dict[tuple[float, float], int] = {}
    count = 0
    for place, line in enumerate(text.splitlines(), 1):
        if not line.strip():
            continue
        fields = _SEPARATOR.split(line.strip())
        count = count or len(fields)
        try:
            if len(fields) != count:
                raise ValueError(f"{len(fields)} fields, and the lines before it have {count}")
            row = _parse_row(fields, frames, kind)
            frame, identity, _, _, width, height, *_ = row
            first = seen.setdefault((frame, identity), place)
            if kind != "detections" and first != place:
                raise ValueError(
                    f"frame {frame:.0f} already has the identity {identity:.0f}, in line {first}"
                )
            if (sized or kind in AREAS) and not (width > 0 and height > 0):
                raise ValueError(
                    f"{AREAS.get(kind, 'a box')} of {width:g}x{height:g} pixels has no area"
                )
        except ValueError as error:
            raise FormatError(f"{name}, line {place}: {error}") from None
        lines.append(row)
    try:
        check_ended(text)
    except ValueError as error:
        raise FormatError(f"{name}: {error}") from None
    return rows_of(lines)


def _parse_row(fields: list[str], frames: int, kind: Kind) -> list[float]:
    if not _NEEDED <= len(fields) <= _MOST:
        raise ValueError(
            f"{len(fields)} numbers, but a line has {_NEEDED} to {_MOST}: frame, id, x, y, width, "
            f"height, score, and up to three more"
        )
    values, more = [number(field) for field in fields[:_NEEDED]], fields[_NEEDED:]
    frame, identity, *_ = values
    further = [number(field) for field in more]
    if not (frame.is_integer() and identity.is_integer()):
        raise ValueError(f"frame and id are whole numbers, not {fields[0]}, {fields[1]}")
    if not 1 <= frame <= frames:
        raise ValueError(f"there is no frame {frame:.0f}; the video has the frames 1 to {frames}")
    ours = kind == "results" and len(fields) == 10 and fields[-2:] == ["1", "-1"]
    if not ours and (kind != "truth" or len(fields) not in (8, 9)):
        return [*values, UNKNOWN, 1]
    if (label := further[0]) not in (UNKNOWN, *CLASSES):
        raise ValueError(f"{more[0]} is not a class; classes are 1 to {CLASSES[-1]}")
    return [*values, label, further[1] if len(further) > 1 else 1]
