"""What cues that compare histograms have in common."""

from __future__ import annotations

from abc import abstractmethod
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from motes import kernels
from motes.core.config import Config
from motes.core.frame import Frame
from motes.core.geometry import Ellipse

Floats = NDArray[np.float64]


M = TypeVar("M")


class HistogramCue(Config, frozen=True):
    """A cue that reads histograms the same way in every frame, and has its model of one alone."""

    @abstractmethod
    def histograms(self, frame: Frame, ellipses: Floats) -> Floats:
        """Return the histogram of each ellipse (N, 5), shape (N, m); zeros where nothing is."""

    def distances(self, model: Any, frame: Frame, ellipses: Floats) -> Floats:
        """Return the Bhattacharyya distance of each ellipse (N, 5) to the model, shape (N,)."""
        return bhattacharyya(self.histograms(frame, ellipses), model.histogram)

    def observe(self, model: Any, frame: Frame, ellipse: Ellipse) -> Floats:
        """Return the region's histogram, (m,); zeros where nothing is seen."""
        histogram: Floats = self.histograms(frame, np.array([ellipse]))[0]
        return histogram

    def update_reading(self, model: M, frame: Frame, ellipse: Ellipse) -> M:
        """Return the model itself: nothing is read in another way after a frame."""
        return model


def bhattacharyya(histograms: Floats, model: Floats) -> Floats:
    """Return the distances sqrt(1 - rho) of histograms (N, m) to a model's (m,), shape (N,).

    Nummiaro et al., equations 6 and 7. A histogram of zeros, of a region where nothing is seen, is
    at distance 1.
    """
    distances = np.empty(len(histograms))
    kernels.histograms.bhattacharyya(histograms, np.sqrt(model), distances)
    return distances
