"""What cues that compare histograms have in common."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from motes import kernels

Floats = NDArray[np.float64]


def bhattacharyya(histograms: Floats, model: Floats) -> Floats:
    """Return the distances sqrt(1 - rho) of histograms (N, m) to a model's (m,), shape (N,).

    Nummiaro et al., equations 6 and 7. A histogram of zeros, of a region where nothing is seen, is
    at distance 1.
    """
    distances = np.empty(len(histograms))
    kernels.bhattacharyya(histograms, np.sqrt(model), distances)
    return distances


def adapted(histogram: Floats, first: Floats, seen: Floats, rate: float, anchor: float) -> Floats:
    """Return a histogram moved towards the one that is seen; where nothing is, it stays.

    It becomes (1 - rate) times itself plus rate times what is seen, where the share `anchor` of the
    latter is taken from the first frame's histogram instead.
    """
    if not seen.any():
        return histogram
    return (1 - rate) * histogram + rate * (anchor * first + (1 - anchor) * seen)
