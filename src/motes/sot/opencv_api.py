"""A tracker with the interface of OpenCV's."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from motes.core.errors import ConfigError
from motes.core.frame import as_rgb
from motes.core.geometry import as_ellipse
from motes.core.track import Status
from motes.sot.presets import TrackerConfig
from motes.sot.tracker import Tracker


class OpenCVTracker:
    """A tracker with the manners of OpenCV's, which needs no OpenCV.

    Images are BGR, boxes (x, y, width, height) of integers.

    Parameters
    ----------
    config, seed
        As for `Tracker`.
    """

    def __init__(self, config: str | TrackerConfig = "default", seed: int = 0) -> None:
        self.tracker = Tracker(config, seed)

    def init(self, image: NDArray[np.uint8], box: Sequence[float]) -> None:
        """Start on the object in a box."""
        as_ellipse(box)  # refuses what is no region at all
        if len(box) != 4:
            raise ConfigError(f"A box has 4 numbers x, y, width, height; got {len(box)}.")
        self.tracker.init(_from_bgr(image), box)

    def update(self, image: NDArray[np.uint8]) -> tuple[bool, tuple[int, int, int, int]]:
        """Return whether the target is being tracked, and its box.

        The first is False exactly when the target is lost; the box is then the best guess.
        """
        track = self.tracker.update(_from_bgr(image))
        x, y, width, height = (round(value) for value in track.box)
        return track.status is Status.TRACKING, (x, y, width, height)


def _from_bgr(image: NDArray[np.uint8]) -> NDArray[np.uint8]:
    image = np.asarray(image)
    return as_rgb(image[:, :, 2::-1] if image.ndim == 3 else image)  # alpha comes last
