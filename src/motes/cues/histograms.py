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
