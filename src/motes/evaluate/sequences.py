"""Sequences with a true box in every frame."""

from __future__ import annotations

import re
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from motes.errors import FormatError


@dataclass(frozen=True, slots=True, eq=False)
class Sequence:
    """One object in one video.

    Attributes
    ----------
    name
        Of the folder.
    source
        What `open_source` reads.
    boxes
        (frames, 4): x, y, width, height, 0-based; NaN where the target is not in the picture.
    """

    name: str
    source: Path
    boxes: NDArray[np.float64]


def load_otb(folder: Path, first_pixel: int = 1) -> Sequence:
    """Read a folder in OTB's layout: `img/` and `groundtruth_rect.txt`.

    Parameters
    ----------
    folder
        The sequence.
    first_pixel
        What the truth calls the first row and column: 1 in OTB.

    Raises
    ------
    FormatError
        If the truth is missing or is not four numbers in each line.
    """
    path = folder / "groundtruth_rect.txt"
    try:
        lines = path.read_text().split("\n")
        rows = [
            [float(v) for v in re.split(r"[,\s]+", line.strip())] for line in lines if line.strip()
        ]
    except (OSError, ValueError) as error:
        raise FormatError(f"Cannot read the truth in {path}: {error}.") from None
    if not rows or {len(row) for row in rows} != {4}:
        raise FormatError(f"{path} needs four numbers x, y, width, height in each line.")
    boxes = np.array(rows)
    boxes[:, :2] -= first_pixel
    return Sequence(folder.name, folder / "img", boxes)
