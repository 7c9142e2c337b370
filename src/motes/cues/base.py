"""The interface of a cue, and the cues by name."""

from __future__ import annotations

from abc import abstractmethod
from typing import Any

import numpy as np
from numpy.typing import NDArray

from motes.core.frame import Frame
from motes.core.geometry import Ellipse
from motes.core.registry import Registry
from motes.core.types import Floats


class Cue:
    """What pixels say about an ellipse: how far a region is from a target model.

    A cue is also a `Config`: `class Hue(Cue, Config, frozen=True)`. Its model is any frozen
    `msgspec.Struct`; what the model holds is the cue's own affair. Methods change neither the model
    nor the frame, and several threads may call them at the same time.

    The model of a cue that is no `AdaptableCue` changes in `update_reading`, if at all.
    """

    __slots__ = ()

    @abstractmethod
    def learn(self, frame: Frame, ellipse: Ellipse) -> Any:
        """Return the target model of the region in `ellipse`."""

    @abstractmethod
    def distances(self, model: Any, frame: Frame, ellipses: Floats) -> Floats:
        """Return how far each ellipse (N, 5) is from the model, shape (N,).

        0 is the same and 1 is as different as can be. The square of a distance is one minus a
        coefficient of similarity, rho, over which the appearance rule and the fusion of cues take
        means. An ellipse has distance 1 where it lies outside the frame, holds a NaN or an
        infinity, or has a half-axis that is not positive. The distance of one ellipse does not
        depend on the other ellipses.
        """

    def update_reading(self, model: Any, frame: Frame, ellipse: Ellipse) -> Any:
        """Return the model for the next frame, after the target was found in `ellipse`.

        It is called only while the tracker is sure. By default, the model stays.
        """
        return model


class AdaptableCue(Cue):
    """A cue that compares histograms, and leaves to the model update how these change.

    Its models have two fields: `histogram` (m,), which the cue compares, and `anchor` (m,), the
    histogram of the first frame.
    """

    __slots__ = ()

    @abstractmethod
    def observe(self, model: Any, frame: Frame, ellipse: Ellipse) -> Floats:
        """Return the region's histogram (m,), sum 1, read as the model's was.

        It holds zeros where nothing is seen, as outside the frame.
        """


def visible(frame: Frame, ellipses: Floats) -> NDArray[np.bool_]:
    """Return which ellipses (N, 5) may see a pixel: finite, of a size, not outside the frame."""
    with np.errstate(invalid="ignore", over="ignore"):  # of those that are none
        x, y, a, b, theta = ellipses.T
        wide = np.hypot(a * np.cos(theta), b * np.sin(theta))
        high = np.hypot(a * np.sin(theta), b * np.cos(theta))
        across = (x + wide > -0.5) & (x - wide < frame.width - 0.5)
        down = (y + high > -0.5) & (y - high < frame.height - 0.5)
    seen: NDArray[np.bool_] = np.isfinite(ellipses).all(axis=1) & (a > 0) & (b > 0) & across & down
    return seen


CUES = Registry[Cue](
    "cue",
    "motes.cues",
    Cue,
    {
        "color": "motes.cues.color:Color",
        "orientation": "motes.cues.structure_tensor:Orientation",
        "edges": "motes.cues.edge_histogram:Edges",
        "hog": "motes.cues.hog:Hog",
        "correlation": "motes.cues.correlation_filter:Correlation",
        "posterior": "motes.cues.color_posterior:Posterior",
    },
    tagged=False,
)
