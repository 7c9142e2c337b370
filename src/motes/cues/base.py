"""The interface of a cue, the base of cues that compare histograms, and the cues by name."""

from __future__ import annotations

from abc import abstractmethod
from typing import Any, ClassVar

import msgspec
import numpy as np
from msgspec.structs import replace
from numpy.typing import NDArray

from motes import kernels
from motes.core.config import Config
from motes.core.errors import ConfigError
from motes.core.frame import Frame
from motes.core.geometry import Ellipse, as_ellipse, as_ellipses
from motes.core.registry import Registry
from motes.core.types import Floats
from motes.cues.sampling import EllipsePixels


class Cue:
    """The interface of a cue: how far regions of a frame are from a target model.

    A cue is also a `Config`: `class Hue(Cue, Config, frozen=True)`. Its model is any frozen
    `msgspec.Struct`; only the cue itself reads the model. Methods change neither the model nor the
    frame, and several threads may call them at the same time.

    If a cue is no `AdaptableCue`, only `update_reading` changes its model.
    """

    __slots__ = ()

    @abstractmethod
    def learn(self, frame: Frame, ellipse: Ellipse) -> Any:
        """Return the target model of the region in `ellipse`.

        It raises a `ConfigError` for what is no ellipse, as with NaN or a half-axis that is not
        positive.
        """

    @abstractmethod
    def distances(self, model: Any, frame: Frame, ellipses: Floats) -> Floats:
        """Return how far each ellipse (N, 5) is from the model, shape (N,).

        0 is the same, 1 is the largest difference. The similarity rho is one minus the square of a
        distance; the appearance rule and the fusion of cues average rho. The distance is 1 for an
        ellipse outside the frame, with NaN or infinity, or with a half-axis that is not positive.
        The distance of one ellipse does not depend on the other ellipses.
        """

    def update_reading(self, model: Any, frame: Frame, ellipse: Ellipse) -> Any:
        """Return the model for the next frame, after the target was found in `ellipse`.

        It is called only in frames in which the target is present. By default, the model stays.
        """
        return model

    def learn_also(self, model: Any, frame: Frame, ellipse: Ellipse) -> Any:
        """Return the model of a target that also looks as in `ellipse` of another frame.

        Each of both looks has half of the model. By default, the model stays.
        """
        return model


class AdaptableCue(Cue):
    """The interface of a cue that compares histograms; a model update changes its models.

    Its models have two fields: `histogram` (m,), which the cue compares, and `anchor` (m,), the
    histogram of the first frame.
    """

    __slots__ = ()

    @abstractmethod
    def observe(self, model: Any, frame: Frame, ellipse: Ellipse) -> Floats:
        """Return the region's histogram (m,), sum 1, read in the same way as the model's.

        It is zero if no pixel is read, as outside the frame.
        """

    def learn_also(self, model: Any, frame: Frame, ellipse: Ellipse) -> Any:
        """Return the model with the mean of its histogram and the region's; the anchor stays."""
        seen = self.observe(model, frame, ellipse)
        check_bins(model, len(seen))
        if not seen.any():
            return model
        return replace(model, histogram=(model.histogram + seen) / 2)


def check_bins(model: Any, bins: int) -> None:
    """Raise a ConfigError unless the histogram of a model has this number of bins."""
    histogram: Any = getattr(model, "histogram", None)
    if np.shape(histogram) != (bins,):
        raise ConfigError(
            f"The target model has no histogram of {bins} bins; let the same cue learn it."
        )


def visible(frame: Frame, ellipses: Floats) -> NDArray[np.bool_]:
    """Return which ellipses (N, 5) may cover a pixel: of positive size, in the frame.

    None that is absurdly large or small, as with NaN, does.
    """
    ellipses, widest = as_ellipses(ellipses), kernels.sampling.WIDEST
    with np.errstate(invalid="ignore", over="ignore"):  # of ellipses with NaN or infinity
        x, y, a, b, theta = ellipses.T
        usual = (np.abs(ellipses) < widest).all(axis=1) & (np.minimum(a, b) > 1 / widest)
        wide = np.hypot(a * np.cos(theta), b * np.sin(theta))
        high = np.hypot(a * np.sin(theta), b * np.cos(theta))
        across = (x + wide > -0.5) & (x - wide < frame.width - 0.5)
        down = (y + high > -0.5) & (y - high < frame.height - 0.5)
    seen: NDArray[np.bool_] = usual & across & down
    return seen


CUES = Registry[type[Cue]](
    "cue",
    "motes.cues",
    Cue,
    {
        "color": "motes.cues.color:Color",
        "orientation": "motes.cues.structure_tensor:Orientation",
        "edges": "motes.cues.gradients:Edges",
        "hog": "motes.cues.gradients:Hog",
        "correlation": "motes.cues.correlation_filter:Correlation",
        "posterior": "motes.cues.color:Posterior",
    },
    tagged=False,
)


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
