"""The interface of a cue."""

from __future__ import annotations

from typing import Any, Protocol, runtime_checkable

import numpy as np
from numpy.typing import NDArray

from motes.core.frame import Frame
from motes.core.geometry import Ellipse


class Cue(Protocol):
    """What a cue must offer.

    Its models are its own affair. One that is no `AdaptableCue` learns in `update_reading`, if at
    all.
    """

    def learn(self, frame: Frame, ellipse: Ellipse) -> Any:
        """Return the target model of the region in `ellipse`."""
        ...

    def distances(
        self, model: Any, frame: Frame, ellipses: NDArray[np.float64]
    ) -> NDArray[np.float64]:
        """Return how far each ellipse (N, 5) is from the model: 0 the same … 1, shape (N,)."""
        ...

    def update_reading(self, model: Any, frame: Frame, ellipse: Ellipse) -> Any:
        """Return the model with what it takes from where the target is, for the next frame."""
        ...


@runtime_checkable
class AdaptableCue(Cue, Protocol):
    """A cue that compares histograms, and leaves it to `adaptation` how these change.

    Its models have two fields: `histogram` (m,), which it compares, and `anchor` (m,), that of the
    first frame.
    """

    def observe(self, model: Any, frame: Frame, ellipse: Ellipse) -> NDArray[np.float64]:
        """Return the region's histogram, read as the model's was; zeros where nothing is seen."""
        ...
