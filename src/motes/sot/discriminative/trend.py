"""The reported size and turn: an alpha-beta filter over what the tracker measures.

The tracker keeps to steps of size and of turn, so that noise does not add up to a drift. Nothing of
what is reported goes back into the tracker, so the report may follow each measurement without
steps.

Kalata, The tracking index: a generalized parameter for alpha-beta and alpha-beta-gamma target
trackers, IEEE Transactions on Aerospace and Electronic Systems 1984.
"""

from __future__ import annotations

from typing import NamedTuple, Self

ALPHA = 0.5
"""Share of a measurement in the reported value."""
BETA = ALPHA**2 / (2 - ALPHA)
"""Share of a measurement's error in the growth, so that the filter is critically damped."""


class Trend(NamedTuple):
    """A reported value and its growth."""

    value: float = 0.0
    """Logarithm of the size relative to the first region's, or the angle since it in radians."""
    growth: float = 0.0
    """Change of the value from one frame to the next."""
    rough: bool = False
    """Whether the value is only that at which a lost target was found. The next measurement then
    replaces it."""

    def predicted(self) -> Self:
        """Return the value in the next frame if nothing is measured there."""
        return self._replace(value=self.value + self.growth)

    def measured(self, value: float) -> Self:
        """Return the value after a frame in which it was measured."""
        if self.rough:
            return type(self)(value)
        error = value - self.predicted().value
        return type(self)(self.predicted().value + ALPHA * error, self.growth + BETA * error)
