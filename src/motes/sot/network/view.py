"""What a network sees around a place: its square of a frame, boxes, scores, and its choice."""

from __future__ import annotations

from functools import cache
from typing import NamedTuple

import msgspec
import numpy as np

from motes import kernels
from motes.core.errors import ConfigError
from motes.core.frame import Frame
from motes.core.geometry import Box
from motes.core.types import Floats, Singles

TINY = 1e-6


class Choice(NamedTuple):
    """How a network's own tracker chooses among its boxes."""

    window: float = 0.455
    """Weight of the place: of 1 at the center of the region and 0 at its border."""
    multiplied: bool = False
    """Whether scores are multiplied by the window, not averaged with it."""
    penalty: float = 0.055
    """How much a box loses whose size or proportions differ from those of the target."""
    rate: float = 0.37
    """Share of the box in the new size, where its score is 1."""


class NetworkView(msgspec.Struct, frozen=True, eq=False):
    """What a network sees in a region of a frame."""

    boxes: Floats
    """(K, 4), x, y, width, height in pixels of the frame; a cell of the score map has one each."""
    scores: Floats
    """(K,), 0 to 1: how much the network holds each for the target."""
    window: Floats
    """(K,), Hann's window over the cells."""
    size: tuple[float, float]
    """Width and height of the place that was looked at."""
    choice: Choice
    """How the network's own tracker chooses."""

    def best(self) -> tuple[Box, float]:
        """Return the box that the network's own tracker chooses, and its score, 0 to 1.

        The box has a size between the target's and that of the one with this score. After Li et
        al., High performance visual tracking with Siamese region proposal network, CVPR 2018,
        section 4.4: a window lowers the scores of far boxes, a penalty exp(-(r s - 1) k) those of
        other proportions and sizes.
        """
        kept, weight = self._kept(), self.choice.window
        if self.choice.multiplied:
            ranks = kept * self.scores * ((1 - weight) + weight * self.window)
        else:
            ranks = kept * self.scores * (1 - weight) + weight * self.window
        row = int(ranks.argmax())
        x, y, *size = self.boxes[row].tolist()
        score = float(self.scores[row])
        rate = float(kept[row]) * score * self.choice.rate
        width, height = (
            own * (1 - rate) + new * rate for own, new in zip(self.size, size, strict=True)
        )
        box = Box(x + (size[0] - width) / 2, y + (size[1] - height) / 2, width, height)
        return box, score

    def _kept(self) -> Floats:
        """Return what the penalty leaves of each score (K,): 1 for the target's own size."""
        width, height = np.maximum(self.boxes[:, 2:].T, TINY)
        own_width, own_height = self.size
        scale = _larger(extent(width, height) / extent(own_width, own_height))
        proportion = _larger(own_width / own_height * height / width)
        return np.exp(-(scale * proportion - 1) * self.choice.penalty)


def view_of(
    sides: Floats, scores: Floats, window: Floats, size: tuple[float, float], choice: Choice
) -> NetworkView:
    """Return a view from sides (K, 4), left, top, right and bottom in a `Box`'s coordinates.

    A box that is no box, or has no number as its score, gets the score 0.
    """
    boxes = np.concatenate([sides[:, :2], sides[:, 2:] - sides[:, :2]], axis=1)
    usable = np.isfinite(scores) & np.isfinite(boxes).all(axis=1) & (boxes[:, 2:] > 0).all(axis=1)
    if not usable.all():
        boxes, scores = np.where(usable[:, None], boxes, 0.0), np.where(usable, scores, 0.0)
    return NetworkView(boxes, scores.clip(0, 1), window, size, choice)


def extent(width: Floats | float, height: Floats | float) -> Floats:
    """Return the side of the square that holds a box with its context (Li et al.)."""
    context = (width + height) / 2
    return np.sqrt((width + context) * (height + context))


def _larger(ratio: Floats) -> Floats:
    """Return a ratio or its inverse, the larger one."""
    return np.maximum(ratio, 1 / ratio)


@cache
def hann(cells: int, *, zero_at_border: bool) -> Floats:
    """Return Hann's window of a map of cells x cells, flat."""
    line = np.hanning(cells) if zero_at_border else np.hanning(cells + 2)[1:-1]
    out = np.outer(line, line).ravel()
    out.flags.writeable = False
    return out


LARGEST_SIDE = 2**20
"""Pixels of the side of the largest region."""
BLACK = np.zeros(3)


class Square(NamedTuple):
    """A square of whole pixels in a frame, which may reach outside."""

    left: int
    top: int
    """Its first column and row of pixels."""
    side: int
    """Its numbers of columns and of rows."""

    @classmethod
    def around(cls, x: float, y: float, side: float) -> Square:
        """Return the region of about this side whose center is nearest to x, y.

        Raises a ConfigError if no frame has a place so large or so far.
        """
        if not max(abs(x), abs(y), side) <= LARGEST_SIDE:
            raise ConfigError(
                f"A network cannot look at a region of {side:.0f} pixels around {x:.0f}, {y:.0f}; "
                f"give a place in the frame."
            )
        whole = max(round(side), 1)
        return cls(round(x - (whole - 1) / 2), round(y - (whole - 1) / 2), whole)


def read(frame: Frame, region: Square, size: int, fill: Floats) -> Singles:
    """Return a region of a frame in `size` rows and columns (1, 3, size, size): RGB, 0 to 255.

    Pixels are mixed bilinearly, not averaged, and rounded as by OpenCV's `resize`: networks have
    learned from such pictures, and choose other boxes where pixels differ by one. Outside the frame
    is the color `fill` (3,).
    """
    out = np.empty((1, 3, size, size), np.float32)
    left, top, side = region
    kernels.network_input.read_square(frame.pixels, left, top, side, fill, out[0])
    return out


def mean_color(frame: Frame) -> Floats:
    """Return the mean of a frame's red, green and blue (3,)."""
    mean: Floats | None = frame.cache.get(mean_color)
    if mean is None:
        mean = frame.cache[mean_color] = np.empty(3)
        kernels.network_input.mean_color(frame.pixels, mean)
    return mean


def reaches_outside(frame: Frame, region: Square) -> bool:
    """Return whether a part of a region lies outside its frame."""
    left, top, side = region
    return min(left, top) < 0 or left + side > frame.width or top + side > frame.height
