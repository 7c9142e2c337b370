"""The reported size: an alpha-beta filter over the sizes that the tracker works with.

The tracker keeps to steps of size, so that noise does not add up to a drift. Nothing of what is
reported goes back into the tracker, so the report may follow each measurement without steps.

Kalata, The tracking index: a generalized parameter for alpha-beta and alpha-beta-gamma target
trackers, IEEE Transactions on Aerospace and Electronic Systems 1984.
"""

from __future__ import annotations

from typing import NamedTuple, Self

ALPHA = 0.5
"""Share of a measurement in the reported size."""
BETA = ALPHA**2 / (2 - ALPHA)
"""Share of a measurement's error in the growth, so that the filter is critically damped."""


class SizeTrend(NamedTuple):
    """The reported size and its growth.

    Attributes
    ----------
    size
        Logarithm of the size, relative to the first region's.
    growth
        Change of `size` from one frame to the next.
    rough
        Whether the size is only that at which a lost target was found. The next measurement then
        replaces it.
    """

    size: float = 0.0
    growth: float = 0.0
    rough: bool = False

    def predicted(self) -> Self:
        """Return the size in the next frame if nothing is measured there."""
        return self._replace(size=self.size + self.growth)

    def measured(self, size: float) -> Self:
        """Return the size after a frame in which it was measured."""
        if self.rough:
            return type(self)(size)
        error = size - self.predicted().size
        return type(self)(self.predicted().size + ALPHA * error, self.growth + BETA * error)
