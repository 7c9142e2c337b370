"""How long objects take through a passage: learned from those that were recognized for sure."""

from __future__ import annotations

import math

SHORTEST = 0.1
"""Seconds; shorter times count as this one, since their logarithm is taken."""
PACE = 0.5
"""Expected deviation of the logarithm: most people take 0.6 to 1.6 times as long as others."""


class PassageTimes:
    """The logarithm of a time is normal, with the conjugate prior of its mean and variance.

    So the next one has Student's distribution: wide at first, and narrower with each time that is
    learned (Murphy 2007, "Conjugate Bayesian analysis of the Gaussian distribution", section 3).

    Parameters
    ----------
    least, most
        Times in seconds that are possible; before any is learned, each costs the same.
    """

    def __init__(self, least: float, most: float) -> None:
        low, high = _log(least), _log(most)
        spread = max((high - low) ** 2 / 12, PACE**2)
        self._mean, self._weight = (low + high) / 2, PACE**2 / spread
        self._shape, self._rate = 1.0, PACE**2
        self._before = self._next

    def learn(self, seconds: float) -> None:
        """Take the time of an object that was recognized for sure."""
        off, share = _log(seconds) - self._mean, self._weight / (self._weight + 1)
        self._mean += (1 - share) * off
        self._weight += 1
        self._shape += 0.5
        self._rate += share * off**2 / 2

    def cost(self, seconds: float) -> float:
        """Return how much less likely a time is than what is usual: a negative logarithm, or 0."""
        time = _log(seconds)
        return max(0.0, _surprise(time, *self._next) - _surprise(time, *self._before))

    @property
    def _next(self) -> tuple[float, float, float]:
        """The middle, the squared scale and the degrees of freedom of the next logarithm."""
        variance = self._rate / self._shape * (1 + 1 / self._weight)
        return self._mean, variance, 2 * self._shape


def _log(seconds: float) -> float:
    return math.log(max(seconds, SHORTEST))


def _surprise(time: float, middle: float, variance: float, freedom: float) -> float:
    """Return the negative logarithm of Student's density, beside that in its middle."""
    return (freedom + 1) / 2 * math.log1p((time - middle) ** 2 / variance / freedom)
