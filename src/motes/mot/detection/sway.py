"""A camera that sways: how far its picture is shifted against the background, in whole pixels.

On a pole or a bridge in the wind, by a hand that rests on a tripod, a picture moves by a few pixels
and comes back. Then each edge of the background would be foreground.
"""

from __future__ import annotations

import math
from functools import lru_cache
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from motes import kernels
from motes.core.types import Bytes, Floats
from motes.kernels.structures import Integers

Shift: TypeAlias = tuple[int, int]
"""How far what a picture shows lies to the right of, and below, where the background shows it."""

FARTHEST = 9
"""Largest shift in x and y that is told, in pixels; a camera that moves so far sways no more."""
STEP = 2
"""Largest change of the shift from frame to frame, at first, in x and y; it may be repeated."""
BLOCK = 16
"""Least width and height of the parts of the picture of which each gives the pixel with the
strongest edge, so that no object has many of them."""
BLOCKS = 1000
"""Largest number of these parts: those of a large picture are larger, which takes no longer."""
EDGE = 20
"""Least strength of an edge, the sum of its gradients in x and y, in gray levels per pixel."""
FEWEST = 40
"""Least number of pixels beside edges from which a shift is told."""
LASTS = 50
"""Frames for which a picture of the background is used."""
MOST = 30
"""Largest difference that counts, in gray levels; what differs by more is something else."""
NOTICED = 1.0
"""Least decrease of the misfit by a shift that is taken, in gray levels."""
SURE = 5.0
"""And least decrease in its own standard errors."""


class Sway:
    """Finds the shift at which a picture fits the background.

    The misfit is the mean of the differences on both sides of strong edges, each up to `MOST`: so
    moving objects, which hide some of them, do not make a shift fit better.

    Attributes
    ----------
    shift
        That of the last picture.
    """

    def __init__(self) -> None:
        self.shift: Shift = (0, 0)
        self._edges = np.empty((3, 0), np.int32)

    @property
    def ends(self) -> bool:
        """Whether the camera has moved as far as can be told, or farther, and sways no more."""
        return max(map(abs, self.shift)) == FARTHEST

    def refer(self, background: Bytes) -> None:
        """Take green of the background (H, W) as what pictures are compared with."""
        self._edges = _edges(background)

    def find(self, pixels: Bytes, step: int = STEP) -> None:
        """Set the shift of the next picture (H, W, 3).

        It is at most `step` pixels from the last one in x and y, or from a better one on the way.
        """
        if self._edges.shape[1] < FEWEST:
            return
        stay = self._apart(pixels, np.array([self.shift]))[0]
        best, left = self.shift, stay
        while stay.mean() > NOTICED:
            near = (_around(step) + best).clip(-FARTHEST, FARTHEST)
            apart = self._apart(pixels, near)
            least = apart.mean(axis=1).argmin()
            if apart[least].mean() >= left.mean():
                break
            x, y = near[least].tolist()
            best, left = (x, y), apart[least]
        if best == self.shift:
            return
        less = stay - left
        if less.mean() > max(NOTICED, SURE * less.std() / math.sqrt(less.size)):
            self.shift = best

    def _apart(self, pixels: Bytes, shifts: NDArray[np.int64]) -> Floats:
        """Return how much a picture differs from the background at shifts (n, 2): (n, edges).

        It is first made as bright as the background there: a brighter picture is not a shifted one.
        """
        places = np.ascontiguousarray(shifts, np.int32)
        out = np.empty((len(places), self._edges.shape[1]))
        kernels.sway.misfits(pixels, self._edges, places, MOST, out)
        return out


@lru_cache
def _around(step: int) -> NDArray[np.int64]:
    """Return all shifts of up to `step` pixels, (n, 2)."""
    return np.indices((2 * step + 1, 2 * step + 1)).reshape(2, -1).T - step


def moved(pixels: Bytes, shift: Shift, behind: Bytes) -> Bytes:
    """Return a picture (H, W, 3) without its shift; what it does not show is as in that behind."""
    x, y = shift
    if x == y == 0:
        return pixels
    out = np.roll(pixels, (-y, -x), axis=(0, 1))
    rows, columns = unseen(shift)
    out[rows], out[:, columns] = behind[rows], behind[:, columns]
    return out


def unseen(shift: Shift) -> tuple[slice, slice]:
    """Return the rows, and the columns, of the background that a picture does not show."""
    x, y = shift
    rows, columns = (slice(-far, None) if far > 0 else slice(-far) for far in (y, x))
    return rows, columns


def _edges(picture: Bytes) -> Integers:
    """Return both sides of the strongest edge of each block of a picture: (3, n).

    They are rows, columns and values of pixels.
    """
    (height, width), margin = picture.shape, FARTHEST
    block = max(BLOCK, math.isqrt(height * width // BLOCKS))
    rows, columns = ((side - 2 * margin - 1) // block for side in (height, width))
    if rows < 1 or columns < 1:
        return np.empty((3, 0), np.int32)
    inner = picture[margin : height - margin, margin : width - margin].astype(np.int16)
    down, right = np.diff(inner, axis=0), np.diff(inner, axis=1)
    here = slice(rows * block), slice(columns * block)
    strength = np.abs(down[here]) + np.abs(right[here])
    blocks = strength.reshape(rows, block, columns, block).swapaxes(1, 2).reshape(-1, block**2)
    strongest = blocks.argmax(axis=1)
    y, x = np.divmod(np.arange(len(blocks)), columns)
    y, x = margin + y * block + strongest // block, margin + x * block + strongest % block
    y, x = (each[blocks.max(axis=1) >= EDGE] for each in (y, x))
    y, x = np.concatenate([y, y + 1]), np.concatenate([x, x + 1])
    return np.stack([y, x, picture[y, x]]).astype(np.int32)
