"""How long objects take through a passage: learned from those that were recognized for sure."""

from __future__ import annotations

import math

SHORTEST = 0.1
"""Seconds; shorter times count as this one, since their logarithm is taken."""
PACE = 0.5
"""Expected deviation of the logarithm: most people take 0.6 to 1.6 times as long as others."""


class PassageTimes:
    """The logarithm of a time is normal, with the conjugate prior of its mean and variance.

    So the next one has Student's distribution, narrower with each time that is learned (Murphy
    2007, "Conjugate Bayesian analysis of the Gaussian distribution", section 3). Before the first
    one nothing is known of the mean.
    """

    def __init__(self) -> None:
        self._mean, self._count, self._rate = 0.0, 0, PACE**2

    def learn(self, seconds: float) -> None:
        """Take the time of an object that was recognized for sure."""
        off, self._count = self._off(seconds), self._count + 1
        self._rate += off**2 / 2 * (1 - 1 / self._count)
        self._mean += off / self._count

    def cost(self, seconds: float) -> float:
        """Return the negative log-likelihood of a time beside the usual one; 0 if none is known."""
        if not self._count:
            return 0.0
        shape = 1 + self._count / 2
        variance = self._rate / shape * (1 + 1 / self._count)
        return (shape + 0.5) * math.log1p(self._off(seconds) ** 2 / variance / (2 * shape))

    def _off(self, seconds: float) -> float:
        return math.log(max(seconds, SHORTEST)) - self._mean
