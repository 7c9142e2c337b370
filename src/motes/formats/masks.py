"""Masks: the runs of their pixels as text, and a folder with a picture of each frame.

Runs alternate between outside and inside the mask, column by column, from the upper left pixel.
From the fourth on, each is written as its difference to the one two places before. A number has
five bits in a character, the lowest first; a sixth bit marks that more follow.
https://github.com/cocodataset/cocoapi (common/maskApi.c, rleToString) defines the text.

A picture, PNG, is white where the object is, and has the name of the frame's image. An object
without a mask of its own fills its ellipse.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from motes.core.errors import FormatError
from motes.core.geometry import Ellipse
from motes.core.types import Flags
from motes.formats.recording import Recording
from motes.formats.shapes import stem_of
from motes.output.overlay import png


def write(recorded: Recording) -> Iterator[tuple[str, bytes]]:
    """Yield the names and contents of the pictures; raise a FormatError if objects are several."""
    height, width = recorded.head.height, recorded.head.width
    here = recorded.only_object("A folder of masks")
    for row in recorded:
        each = here.get(row.frame)
        if each is None:
            white = np.zeros((height, width), np.bool_)
        elif each.mask is None:
            white = _inside(each.ellipse, height, width)
        else:
            white = decode(each.mask, height, width)
        yield f"{stem_of(row)}.png", png(255 * white.astype(np.uint8))


def _inside(ellipse: Ellipse, height: int, width: int) -> Flags:
    """Return which pixels (height, width) have their centers in an ellipse."""
    y, x = np.ogrid[:height, :width]
    along, across = ellipse.inner(x - ellipse.x, y - ellipse.y)
    inside: Flags = along**2 + across**2 <= 1
    return inside


BITS = 5
ZERO = 48
"""The character of the number 0."""


def encode(mask: NDArray[np.bool_]) -> str:
    """Return the runs of a mask (height, width) as text."""
    pixels = np.concatenate([[False], mask.ravel(order="F")])
    changes = np.flatnonzero(pixels[1:] != pixels[:-1])
    return text_of(np.diff(np.concatenate([[0], changes, [mask.size]])).tolist())


def text_of(runs: Sequence[int]) -> str:
    """Return the lengths of runs as text."""
    return "".join(_number(run - runs[i - 2] if i > 2 else run) for i, run in enumerate(runs))


def _number(value: int) -> str:
    text = ""
    while True:
        low, value = value & (2**BITS - 1), value >> BITS
        # All further bits are the sign, which the last character's highest bit holds.
        last = value == (-1 if low & 2 ** (BITS - 1) else 0)
        text += chr(ZERO + (low if last else low | 2**BITS))
        if last:
            return text


def runs_of(text: str, height: int, width: int) -> list[int]:
    """Return the lengths of the runs in a text; raise a FormatError if they do not fit a mask."""
    runs: list[int] = []
    value = shift = 0
    for character in text:
        part = ord(character) - ZERO
        value |= (part & (2**BITS - 1)) << shift
        shift += BITS
        if part & 2**BITS:
            continue
        if part & 2 ** (BITS - 1):
            value -= 1 << shift
        runs.append(value + (runs[-2] if len(runs) > 2 else 0))
        value = shift = 0
    return fitting(runs, height, width)


def fitting(runs: list[int], height: int, width: int) -> list[int]:
    """Return runs; raise a FormatError if they do not fit a mask."""
    if min(runs, default=0) < 0 or sum(runs) != height * width:
        raise FormatError(f"a mask's runs do not fill its {width}x{height} pixels")
    return runs


def area(text: str, height: int, width: int) -> int:
    """Return the number of pixels in a mask; raise a FormatError if its runs do not fit."""
    return sum(runs_of(text, height, width)[1::2])


def decode(text: str, height: int, width: int) -> NDArray[np.bool_]:
    """Return the mask (height, width) of runs; raise a FormatError if they do not fit."""
    runs = runs_of(text, height, width)
    inside: NDArray[np.bool_] = np.repeat(np.arange(len(runs)) % 2 == 1, runs)
    return inside.reshape(width, height).T


def mask_runs(segmentation: Any, height: int, width: int) -> str | None:
    """Return the text of a COCO segmentation with `counts`; None for polygons.

    Raises a KeyError if a part is missing; and a FormatError, TypeError or ValueError if it is not
    of a picture of this size, or damaged.
    """
    if not isinstance(segmentation, dict):
        return None
    counts, size = segmentation["counts"], segmentation["size"]
    if list(size) != [height, width]:
        raise FormatError(f"its mask's size is {size}, and that of its image [{height}, {width}]")
    if isinstance(counts, str):
        runs_of(counts, height, width)
        return counts
    return text_of(fitting([int(run) for run in counts], height, width))
