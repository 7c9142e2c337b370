"""Boxes with identities as arrays: truth, detections and results of the MOTChallenge."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from motes import Box, Detection
from motes.core import Floats
from motes.formats import read_boxes

Integers = NDArray[np.int64]
Kind = Literal["truth", "results", "detections"]

UNKNOWN = -1
"""Class of a box that has none."""
CLASS = 7
"""The column of the class; the next one is the visibility."""


@dataclass(frozen=True, slots=True, eq=False)
class MotRows:
    """Boxes in the order of their frames."""

    frames: Integers
    ids: Integers
    """(n,), frames count from 1."""
    boxes: Floats
    """(n, 4): x, y, width, height; the first pixel is 1."""
    scores: Floats
    """(n,), confidences or, in the truth, flags."""
    classes: Integers
    """(n,), `UNKNOWN` where there is none."""
    visibilities: Floats
    """(n,), the visible part of each object, 0 to 1; 1 where it is not known."""

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

    def detections(self, index: int) -> list[Detection]:
        """Return the rows of a frame, which counts from 0, as detections."""
        return [Detection(box, score) for _, box, score in self.listed(index)]

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


def line_of(index: int, identity: int, box: Box, score: float = 1.0) -> list[float]:
    """Return a box for `rows_of`; the frame and the pixels given count from 0."""
    return [index + 1, identity, box.x + 1, box.y + 1, box.width, box.height, score]


def rows_of(lines: Sequence[Sequence[float]]) -> MotRows:
    """Return rows from lists frame, id, x, y, width, height, score; frames in any order.

    Each list may end with the class and the visibility.
    """
    table = np.array(lines, np.float64).reshape(len(lines), -1 if lines else CLASS)
    table = table[np.argsort(table[:, 0], kind="stable")]
    usual = np.tile([UNKNOWN, 1.0], (len(table), 1))
    table = np.hstack([table, usual[:, table.shape[1] - CLASS :]])
    frames, ids, classes = table[:, [0, 1, CLASS]].astype(np.int64).T
    return MotRows(frames, ids, table[:, 2:6], table[:, 6], classes, table[:, CLASS + 1])


def read_rows(path: Path, frames: int, kind: Kind) -> MotRows:
    """Return the rows of a video; parameters, classes and errors are those of `read_boxes`."""
    return rows_of(read_boxes(path, frames, kind))
