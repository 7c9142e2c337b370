"""New particles in the places where a target may appear."""

from __future__ import annotations

import numpy as np

from motes.core.geometry import Ellipse
from motes.core.types import Floats


def scatter(rng: np.random.Generator, places: Floats, size: Ellipse, n: int) -> Floats:
    """Return n ellipses (n, 5) of one size, centers uniform over the boxes `places` (R, 4)."""
    area = places[:, 2] * places[:, 3]
    shares = np.cumsum(area / area.sum())
    chosen = places[(shares / shares[-1]).searchsorted(rng.random(n), side="right")]
    ellipses = np.empty((n, 5))
    ellipses[:, :2] = chosen[:, :2] - 0.5 + rng.random((n, 2)) * chosen[:, 2:]
    ellipses[:, 2:] = size[2:]
    return ellipses
