"""At which of two places the target is, where two experts part.

A single frame must not decide: a neighbor who looks alike is the surer one now and then. So the
difference of their evidence is added up, as in Wald's sequential test (Annals of Mathematical
Statistics 1945).
"""

from __future__ import annotations

import math
from typing import NamedTuple, Self

from motes.core.geometry import Ellipse

APART = 0.3
"""Two places are different targets from this distance on, in mean sides of the target."""
DECIDED = 1.0
"""Log odds that decide for a place, or between two places: nearly three to one."""


def apart(place: Ellipse, other: Ellipse) -> bool:
    """Return whether two places are too far from each other to be the same target."""
    return math.hypot(place.x - other.x, place.y - other.y) > APART * other.side


class Rival(NamedTuple):
    """A second place, and the evidence for it."""

    place: Ellipse
    """Where it is, if it is alive."""
    lead: float = 0.0
    """Log odds that it is the target and not what is followed, added up over frames."""
    alive: bool = False
    """Whether there is one."""

    @property
    def wins(self) -> bool:
        """Whether the rival is the likelier target."""
        return self.lead > DECIDED

    @property
    def loses(self) -> bool:
        """Whether the rival is not the target."""
        return self.lead < -DECIDED

    def after(self, place: Ellipse, difference: float) -> Self:
        """Return the rival after a frame: its place, and the log odds that it adds there."""
        return type(self)(place, self.lead + difference, alive=True)
