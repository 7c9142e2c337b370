"""A tracker with the interface of OpenCV's trackers."""

from __future__ import annotations

import contextlib
import copy
from collections.abc import Sequence
from typing import Any, Self

from numpy.typing import NDArray

from motes.core.errors import ConfigError
from motes.core.frame import from_bgr
from motes.core.track import TRACKING, Track
from motes.core.types import Numbers
from motes.sot.presets import TrackerConfig
from motes.sot.tracker import Tracker


class OpenCVTracker:
    """A tracker with the methods of OpenCV's `cv2.Tracker`: `create`, `init` and `update`.

    OpenCV need not be installed. Images are BGR (or gray, or BGR with alpha), as OpenCV reads them.

    Parameters
    ----------
    config, seed, network
        As for `Tracker`.

    Attributes
    ----------
    tracker
        The `Tracker` behind it, for `correct`, `save` and `load`. Its own images are RGB.
    """

    def __init__(
        self,
        config: str | TrackerConfig = "default",
        seed: int = 0,
        *,
        network: str | Sequence[str] = (),
    ) -> None:
        self.tracker = Tracker(config, seed, network=network)

    @classmethod
    def create(
        cls,
        config: str | TrackerConfig = "default",
        seed: int = 0,
        *,
        network: str | Sequence[str] = (),
    ) -> Self:
        """Return a new tracker, as `cv2.TrackerCSRT.create()` does."""
        return cls(config, seed, network=network)

    def init(self, image: NDArray[Any], boundingBox: Numbers) -> None:  # noqa: N803
        """Start on the object in a box (x, y, width, height).

        Raises
        ------
        ConfigError
            If the box is not valid, or does not fit the image.
        """
        with contextlib.suppress(TypeError):  # what has no length is refused below
            if (count := len(boundingBox)) != 4:
                raise ConfigError(f"A box has 4 numbers x, y, width, height; got {count}.")
        self.tracker.init(from_bgr(image), boundingBox)

    def update(self, image: NDArray[Any]) -> tuple[bool, tuple[int, int, int, int]]:
        """Return whether the target is tracked, and its box in whole pixels.

        While the target is not tracked, the box is the best guess.

        Raises
        ------
        ConfigError
            Before `init`.
        SourceError
            If the size of the image has changed, or it is None, as at the end of a film.
        """
        track = self.tracker.update(from_bgr(image))
        x, y, width, height = track.ellipse.box
        box = round(x), round(y), round(width), round(height)
        return track.status is TRACKING, box

    @property
    def track(self) -> Track:
        """What is known of the last image: the confidence, the status, the box in fractions.

        Raises
        ------
        ConfigError
            Before `init`.
        """
        if not hasattr(self.tracker, "info"):
            raise ConfigError("There is no track before init; call it with the first image.")
        return self.tracker.info.track

    def __copy__(self) -> Self:
        """Return an independent tracker; `copy.copy` and `copy.deepcopy` do the same."""
        return copy.deepcopy(self)
