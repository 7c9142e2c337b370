"""The base of cues that compare histograms."""

from __future__ import annotations

from abc import abstractmethod
from typing import Any, ClassVar

import msgspec
import numpy as np
from msgspec.structs import replace

from motes import kernels
from motes.core.config import Config
from motes.core.frame import Frame
from motes.core.geometry import Ellipse, as_ellipse
from motes.core.types import Floats
from motes.cues.base import AdaptableCue, check_bins
from motes.cues.sampling import EllipsePixels


class HistogramModel(msgspec.Struct, frozen=True, eq=False, tag="histogram"):
    """A target's histogram."""

    histogram: Floats
    """(m,), sums to 1; zeros if no pixel was read."""
    anchor: Floats
    """(m,), the histogram of the first frame. The model update keeps the model near it."""


class HistogramCue(AdaptableCue, Config, frozen=True):
    """The base of a cue that compares histograms; a subclass needs the method `histograms` only."""

    model_type: ClassVar[type[HistogramModel]] = HistogramModel

    @abstractmethod
    def histograms(self, frame: Frame, ellipses: Floats) -> Floats:
        """Return the histogram of each ellipse (N, 5), shape (N, m).

        Each row sums to 1, or is zero if no pixel is read, as outside the frame or for NaN.
        """

    def learn(self, frame: Frame, ellipse: Ellipse) -> Any:
        """Return the target model of the region in `ellipse`."""
        histogram = self.histograms(frame, np.array([as_ellipse(ellipse)]))[0]
        return self.model_type(histogram, histogram)

    def distances(self, model: Any, frame: Frame, ellipses: Floats) -> Floats:
        """Return the Bhattacharyya distance of each ellipse (N, 5) to the model, shape (N,)."""
        histograms = self.histograms(frame, ellipses)
        check_bins(model, histograms.shape[1])
        return bhattacharyya(histograms, model.histogram)

    def observe(self, model: Any, frame: Frame, ellipse: Ellipse) -> Floats:
        """Return the region's histogram, (m,); zeros if no pixel is read."""
        histogram: Floats = self.histograms(frame, np.array([ellipse], float))[0]
        return histogram


class PixelHistogramCue(HistogramCue, EllipsePixels, frozen=True):
    """The base of a histogram of an ellipse's weighted pixels."""

    def learn(self, frame: Frame, ellipse: Ellipse) -> Any:
        """Return the target model of the region in `ellipse`, read with `sampling.dense`."""
        return super(PixelHistogramCue, replace(self, sampling=self.sampling.dense)).learn(
            frame, ellipse
        )


def bhattacharyya(histograms: Floats, model: Floats) -> Floats:
    """Return the distances sqrt(1 - rho) of histograms (N, m) to a model's (m,), shape (N,).

    Nummiaro et al., equations 6 and 7. A histogram of zeros, from a region without pixels, has
    distance 1.
    """
    distances = np.empty(len(histograms))
    kernels.histograms.bhattacharyya(histograms, np.sqrt(model), distances)
    return distances
