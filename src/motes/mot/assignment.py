"""One-to-one assignment of least cost."""

from __future__ import annotations

import numpy as np

from motes.core.types import Floats
from motes.mot.pairs import Integers

DENSE = 2**16
"""Largest number of cells for which a full matrix of costs takes the least time."""


def assign(costs: Floats) -> list[tuple[int, int]]:
    """Return rows and columns of the one-to-one assignment of least cost.

    As many pairs as possible are formed of those that are not ruled out, (n, m) with infinite cost.
    """
    from scipy.optimize import linear_sum_assignment  # takes half a second to import

    allowed = np.isfinite(costs)
    if not allowed.any():
        return []
    # A pair that is ruled out costs more than any number of others.
    forbidden = 1 + 2 * min(costs.shape) * costs[allowed].max()
    rows, columns = linear_sum_assignment(np.where(allowed, costs, forbidden))
    pairs = zip(rows.tolist(), columns.tolist(), strict=True)
    return [(i, j) for i, j in pairs if allowed[i, j]]


def assign_pairs(
    i: Integers, j: Integers, costs: Floats, shape: tuple[int, int]
) -> list[tuple[int, int]]:
    """Return the pairs of the one-to-one assignment of least cost where few are possible, sorted.

    As many pairs as possible are formed of those with finite costs.

    Parameters
    ----------
    i, j, costs
        (k,) each: rows, columns and costs of the pairs; all others are ruled out.
    shape
        Numbers of rows and of columns.
    """
    possible = np.isfinite(costs)
    i, j, costs = i[possible], j[possible], costs[possible]
    n, m = shape
    if n * m <= DENSE:
        matrix = np.full(shape, np.inf)
        matrix[i, j] = costs
        return assign(matrix)
    from scipy.sparse import csr_array
    from scipy.sparse.csgraph import min_weight_full_bipartite_matching

    # Each row also has a column of its own that stands for no pair, and costs more than any number
    # of pairs.
    none = 1 + 2 * min(n, m) * costs.max(initial=0.0)
    own = np.arange(n)
    values = 1 + np.concatenate([costs, np.full(n, none)])  # a cost of 0 would be no pair
    places = np.concatenate([i, own]), np.concatenate([j, m + own])
    rows, columns = min_weight_full_bipartite_matching(csr_array((values, places), (n, m + n)))
    return sorted((a, b) for a, b in zip(rows.tolist(), columns.tolist(), strict=True) if b < m)
