"""Who is who: which of those known before is each of those seen now, all decided at once."""

from __future__ import annotations

import itertools
import math
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from motes.core.types import Floats

FEW = 5040
"""Most assignments that are compared one by one, in half a millisecond: all of 7 to 7."""


def who_is_who(costs: Floats) -> tuple[NDArray[np.int64], Floats]:
    """Return who each track is, and how certain that is.

    The likeliest one-to-one assignment is the one with the least sum of costs. Its certainty comes
    from Bayes' theorem over all assignments; where they are too many, over the best one and those
    that differ from it by one exchange or one move, which are the likeliest mistakes.

    Parameters
    ----------
    costs
        (n, m), n <= m: for each track that is seen now and each model that is kept from before, the
        negative logarithm of how likely the track looks and moves as it does if it is that model.
        Infinite where it cannot be. That a track is nobody known is one column more for each track,
        with its cost in that row alone; some assignment must be possible.

    Returns
    -------
    models, certainty
        (n,) each: the model of each track, and the posterior probability that it is that one.
    """
    n, m = costs.shape
    rows = np.arange(n)
    if math.perm(m, n) <= FEW:
        each = _all(n, m)
    else:
        from scipy.optimize import linear_sum_assignment  # takes half a second to import

        each = _near(linear_sum_assignment(costs)[1], m)
    sums = costs[rows, each].sum(axis=1)
    best = each[sums.argmin()]
    odds = np.exp(sums.min() - sums)
    certainty: Floats = (odds[:, None] * (each == best)).sum(axis=0) / odds.sum()
    return best, certainty


@lru_cache(maxsize=64)
def _all(n: int, m: int) -> NDArray[np.int64]:
    """Return all ways to give n rows a column each of m, (ways, n)."""
    return np.array(list(itertools.permutations(range(m), n)), np.int64).reshape(-1, n)


def _near(best: NDArray[np.int64], m: int) -> NDArray[np.int64]:
    """Return an assignment, and all that one exchange or one move to a free column makes of it."""
    i, j = np.triu_indices(len(best), 1)
    k, free = np.meshgrid(np.arange(len(best)), np.setdiff1d(np.arange(m), best))
    ways = np.tile(best, (1 + i.size + k.size, 1))
    exchanged, moved = 1 + np.arange(i.size), 1 + i.size + np.arange(k.size)
    ways[exchanged, i], ways[exchanged, j] = best[j], best[i]
    ways[moved, k.ravel()] = free.ravel()
    return ways
