"""An object that goes behind something: one side stands still, the other goes on."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

from motes.core.geometry import Box

WINDOW = 0.3
"""Seconds over which sides are compared; in more an object may have gone."""
FEW = 5
"""Detections in the window; fewer tell nothing, as boxes tremble."""
MOVED = 0.15
"""The other side has moved by more than this share of the object's width in the window."""
STILL = 0.1
"""The hidden side has moved by less than this share of what the other one has."""
FASTER = 0.5
"""The other side goes on as fast as the object did at the window's begin, but for this share. The
foot of a walker that swings is twice as fast, while the other one stands."""


class Sighting(NamedTuple):
    """A detection of an object."""

    time: float
    box: Box
    speed: float
    """The object's velocity in x before it, in pixels a second."""


class Hiding(NamedTuple):
    """What hides an object more and more."""

    side: int
    """The side of the object that it covers: -1 is the left one, 1 the right one."""
    speed: float
    """The object's velocity in x before that. The center of what is seen has half of it."""
    width: float
    """The object's width before that."""


def hiding_of(recent: Sequence[Sighting], width: float) -> Hiding | None:
    """Return what hides an object of a width, by its detections in the last `WINDOW` seconds."""
    (begin, first, speed), (now, last, _) = recent[0], recent[-1]
    if len(recent) < FEW or now - begin < WINDOW / 2:
        return None
    left, right = last.x - first.x, last.x + last.width - first.x - first.width
    for side, still, moved in ((1, right, left), (-1, left, right)):
        goes_on = abs(moved / (now - begin) - speed) < FASTER * abs(speed)
        if side * moved > MOVED * width and abs(still) < STILL * abs(moved) and goes_on:
            return Hiding(side, speed, first.width)
    return None
