"""The region of one object in each frame: texts of datasets, rows of motes, masks."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
from PIL import Image

from motes import Ellipse, FormatError, Status
from motes.core import read_text
from motes.formats import ABSENT, MAX_FRAME, TruthRegion, read_regions
from motes.rows import table_of

PLACED = (Status.TRACKING, Status.INTERPOLATED)
"""The statuses of rows in frames that have a target."""


def read_truth(path: Path) -> list[TruthRegion]:
    """Return the regions of a text for `read_regions`, or of rows of motes, one for each frame.

    Raises
    ------
    FormatError
        If it cannot be read, is neither, or has a frame twice.
    """
    text = read_text(path, FormatError)
    if not text.lstrip().startswith(("frame,", "{")):
        try:
            return read_regions(text)
        except FormatError as error:
            raise FormatError(f"{path.name}, {error}") from None
    table = table_of(text, path.name, "jsonl" if text.lstrip()[0] == "{" else "csv")
    names = table.dtype.names or ()
    if missing := [name for name in Ellipse._fields if name not in names]:
        raise FormatError(f"{path.name}: a track has the column {missing[0]}")
    frames = table["frame"].tolist()
    if len({*frames}) < len(frames) or (frames and not 0 <= min(frames) <= max(frames) < MAX_FRAME):
        raise FormatError(f"{path.name} has a frame twice, or one that no film has")
    regions = [ABSENT] * (max(frames, default=-1) + 1)
    for frame, row in zip(frames, table, strict=True):
        ellipse = Ellipse(*(float(row[name]) for name in Ellipse._fields))
        placed = "status" not in names or row["status"] in PLACED
        if placed and all(map(math.isfinite, ellipse)) and min(ellipse.a, ellipse.b) > 0:
            regions[frame] = TruthRegion(ellipse.box, ellipse)
    return regions


def read_mask(path: Path) -> TruthRegion:
    """Return the region of the pixels of an image that are not zero (black).

    Raises
    ------
    FormatError
        If the image cannot be read, or has a lossy format, which changes zeros.
    """
    if path.suffix.lower() in (".jpg", ".jpeg"):
        raise FormatError(f"the mask {path.name} is JPEG, which alters zeros; save masks as PNG")
    try:
        with Image.open(path) as image:
            values = np.asarray(image.convert("RGB") if image.mode in ("RGBA", "LA") else image)
    except Exception as error:  # decoders of damaged images raise errors of many kinds
        raise FormatError(f"the mask {path.name} cannot be read; replace it") from error
    y, x = np.nonzero(values.any(axis=2) if values.ndim == 3 else values)
    return TruthRegion.of_pixels(x, y)
