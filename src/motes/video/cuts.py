"""Whether a film is cut to another picture, or the light changes at once.

Histograms of color tell a cut, as PySceneDetect's HistogramDetector does. But a lamp that is
switched on changes them too: a cut changes what is where as well, and light does not.
"""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Iterable, Iterator
from itertools import takewhile
from typing import Literal, NamedTuple, TypeAlias

import numpy as np

from motes import kernels
from motes.core.frame import Frame
from motes.core.types import Floats, correlation, median

Change: TypeAlias = Literal["cut", "light"]

COLORS = 0.3
"""Hellinger distance of histograms of color from which on a picture may be another one. In 59 films
without a cut successive pictures were 0.29 apart at most, those of two films 0.35 or more in 99 of
100 pairs."""
GRAYS = 0.15
"""The same where both have no colors: of 30 of these films in gray, successive pictures were 0.13
apart at most, and those of two films 0.15 or more in 93 of 100 pairs."""
COLORLESS = 3.0
"""Gray levels; the channels of a picture in gray differ by less in the mean, also decoded."""
STRUCTURE = 0.7
"""And the correlation of their gray values below which it is: these have 0.61 at least, and 0.66 at
most."""
FLAT = 4.0
"""Gray levels; a picture that deviates by less shows nothing, as between two fades."""
LIGHT = 0.2
"""Change of the light, as a logarithm, in a second."""
LATELY = 1.0
"""Seconds over which light is compared."""
GRID = 32
SAMPLES = 128
"""Columns of the small gray picture, and of the points whose colors are counted, about."""


class _Look(NamedTuple):
    """What is kept of a picture."""

    time: float
    gray: Floats
    """(h, w), small."""
    colors: Floats
    """(512,), shares of colors, each channel in eight bins."""
    colorless: bool


class PictureChanges:
    """Tells sudden changes of the whole picture; frames come in order, or in reversed order."""

    def __init__(self) -> None:
        self._past = deque[_Look]()
        self._restless = False
        """Whether the last picture was another one: noise and strobes cut nothing."""

    def update(self, frame: Frame) -> Change | None:
        """Return how the picture has changed in a frame; None if it goes on."""
        now, past = _look(frame), self._past
        if now.gray.std() < FLAT:
            return None
        change: Change | None = None
        if past and past[-1].gray.shape != now.gray.shape:
            past.clear()
        other = (
            bool(past)
            and _other_colors(past[-1], now)
            and correlation(past[-1].gray, now.gray) < STRUCTURE
        )
        if other:
            change = None if self._restless else "cut"
        elif (
            past
            and abs(_lighter(past[0], now)) > LIGHT
            and correlation(past[0].gray, now.gray) >= STRUCTURE
        ):
            change = "light"
        if other or change is not None:
            past.clear()
        self._restless = other
        past.append(now)
        while abs(now.time - past[0].time) > LATELY:
            past.popleft()
        return change


def cuts_in(frames: Iterable[Frame]) -> Iterator[int]:
    """Yield the indices of frames with which a film is cut to another picture."""
    changes = PictureChanges()
    for frame in frames:
        if changes.update(frame) == "cut":
            yield frame.index


def before_cut(frames: Iterable[Frame]) -> Iterator[Frame]:
    """Yield frames up to the first cut."""
    changes = PictureChanges()
    return takewhile(lambda frame: changes.update(frame) != "cut", frames)


def _look(frame: Frame) -> _Look:
    step = max(1, frame.width // SAMPLES)
    height, width = -(-frame.height // step), -(-frame.width // step)
    block = max(1, min(width // GRID, height))
    colors, sums = np.empty(512), np.empty((height // block, width // block))
    apart = kernels.cuts.look(frame.pixels, step, block, colors, sums)
    gray, shares = sums / (3 * block**2), colors / (height * width)
    return _Look(frame.time, gray, shares, apart < COLORLESS)


def _other_colors(one: _Look, other: _Look) -> bool:
    """Return whether colors differ as those of two pictures, by their Hellinger distance."""
    apart = math.sqrt(max(0.0, 1 - float(np.sqrt(one.colors * other.colors).sum())))
    return apart > (GRAYS if one.colorless and other.colorless else COLORS)


def _lighter(before: _Look, now: _Look) -> float:
    """Return the logarithm of the factor between the gray values; objects do not change it."""
    return math.log(median((1 + now.gray) / (1 + before.gray)))
