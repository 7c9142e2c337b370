"""The estimate: one ellipse and its uncertainty, from weighted particles."""

from __future__ import annotations

import numpy as np

from motes import kernels
from motes.core.geometry import Ellipse
from motes.core.types import Floats


def mean_ellipse(ellipses: Floats, weights: Floats) -> tuple[Ellipse, Floats]:
    """Return the mean E[S] = sum of pi s (Nummiaro et al., equation 1) and its covariance.

    Parameters
    ----------
    ellipses
        (N, 5): x, y, a, b, theta. An ellipse is the same after half a turn, so the angle's mean
        and deviations are taken modulo pi.
    weights
        (N,), sum 1.

    Returns
    -------
    The mean ellipse, theta in (-pi/2, pi/2], and the (5, 5) covariance of x, y, a, b, theta.
    """
    mean, covariance = np.empty(5), np.empty((5, 5))
    kernels.particles.moments(ellipses, weights, mean, covariance)
    return Ellipse(*mean.tolist()), covariance
