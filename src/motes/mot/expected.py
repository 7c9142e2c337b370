"""Objects that are expected in the next frame, as another camera has seen them.

Nummiaro et al., section VII: the other tracker "can then initialize a sample distribution using
this knowledge".
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from motes.core.geometry import Ellipse
from motes.core.types import Floats
from motes.cues.color import Color, ColorModel

CUE = Color()
"""The cue whose histograms cameras exchange."""


class Expected(NamedTuple):
    """An object that may appear in the next frame."""

    key: int
    """Its number where it comes from."""
    samples: Floats
    """(N, 5), ellipses where it may be: the initial distribution of its filter."""
    velocity: Floats
    """(2,), in pixels a second."""
    model: ColorModel
    """Its histogram, as `CUE` learns it."""
    certain: bool
    """Whether it must be there, as when another camera sees it now. Then it may begin without a
    detection, and it is the object with this key."""


def normal_samples(
    rng: np.random.Generator, mean: Ellipse, covariance: Floats, count: int
) -> Floats:
    """Return samples (count, 5) of a normal distribution of ellipses; half-axes are 1 or more.

    Parameters
    ----------
    rng
        Source of randomness.
    mean
        The mean ellipse.
    covariance
        (5, 5), of x, y, a, b, theta.
    count
        Number of samples.
    """
    # The eigenvalues of a covariance that was estimated from few particles may be slightly below 0.
    values, vectors = np.linalg.eigh((covariance + covariance.T) / 2)
    spread = vectors * np.sqrt(np.maximum(values, 0))
    samples: Floats = np.array(mean) + rng.standard_normal((count, 5)) @ spread.T
    samples[:, 2:4] = np.maximum(samples[:, 2:4], 1.0)
    return samples
