"""Other people's trackers, to measure ours against: OpenCV's, behind `Tracker`-like methods.

cv2 is imported only when a peer is asked for.
"""

from __future__ import annotations

import ctypes
import os
from collections.abc import Callable, Sequence
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from motes.core.errors import ConfigError, MissingDependencyError


class Peer(Protocol):
    """A tracker in OpenCV's manner; images are BGR."""

    def init(self, image: NDArray[np.uint8], box: Sequence[int]) -> None:
        """Start on the object in a box (x, y, width, height)."""
        ...

    def update(self, image: NDArray[np.uint8]) -> tuple[bool, Sequence[float]]:
        """Return whether the target was found, and its box."""
        ...


class CamShift:
    """OpenCV's CamShift in the usual pipeline: HSV, back-projection of a hue histogram, CamShift.

    Pixels with saturation under 60 or value under 32 are left out of the histogram, as in OpenCV's
    own example.
    """

    def __init__(self, cv2: Any) -> None:
        self._cv2 = cv2

    def init(self, image: NDArray[np.uint8], box: Sequence[int]) -> None:
        """Learn the hue histogram of a box."""
        cv2 = self._cv2
        x, y, width, height = box
        hsv = cv2.cvtColor(image[y : y + height, x : x + width], cv2.COLOR_BGR2HSV)
        mask = cv2.inRange(hsv, (0, 60, 32), (180, 255, 255))
        self._histogram = cv2.calcHist([hsv], [0], mask, [180], [0, 180])
        cv2.normalize(self._histogram, self._histogram, 0, 255, cv2.NORM_MINMAX)
        self._box = (x, y, width, height)

    def update(self, image: NDArray[np.uint8]) -> tuple[bool, Sequence[float]]:
        """Follow the hue's center of mass."""
        cv2 = self._cv2
        hsv = cv2.cvtColor(image, cv2.COLOR_BGR2HSV)
        likely = cv2.calcBackProject([hsv], [0], self._histogram, [0, 180], 1)
        stop = (cv2.TERM_CRITERIA_EPS | cv2.TERM_CRITERIA_COUNT, 10, 1)
        _, box = cv2.CamShift(likely, self._box, stop)
        found = box[2] > 0 and box[3] > 0
        if found:
            self._box = box
        return found, self._box


PEERS: dict[str, Callable[[Any], Peer]] = {
    "cv2:csrt": lambda cv2: cv2.TrackerCSRT_create(),
    "cv2:kcf": lambda cv2: cv2.TrackerKCF_create(),
    "cv2:mil": lambda cv2: cv2.TrackerMIL_create(),
    "cv2:mosse": lambda cv2: cv2.legacy.TrackerMOSSE_create(),
    "cv2:medianflow": lambda cv2: cv2.legacy.TrackerMedianFlow_create(),
    "cv2:camshift": CamShift,
}

STOCHASTIC = frozenset({"cv2:mil"})
"""Peers that draw random numbers; the others do the same every time."""


def opencv(name: str) -> Any:
    """Return the module cv2, on one thread, if it has the peer of a name.

    Raises
    ------
    ConfigError
        For an unknown name.
    MissingDependencyError
        If OpenCV is not installed, or without this tracker.
    """
    if name not in PEERS:
        raise ConfigError(f"No peer {name!r}; known are {', '.join(PEERS)}.")
    try:
        import cv2
    except ImportError:
        raise MissingDependencyError(
            "Comparing with OpenCV needs it; install it with: pip install 'motes[opencv]'."
        ) from None
    cv2.setNumThreads(1)
    try:
        PEERS[name](cv2)
    except AttributeError:
        raise MissingDependencyError(
            f"This OpenCV {cv2.__version__} has no {name}; install opencv-contrib-python-headless."
        ) from None
    return cv2


def peer(name: str, seed: int = 0) -> Peer:
    """Return a fresh tracker of OpenCV's, on one thread.

    Start it before the next one is made: a stochastic one takes its random numbers from those of
    the whole process, which are seeded here, when it starts.

    Raises
    ------
    ConfigError, MissingDependencyError
        As `opencv` does.
    """
    cv2 = opencv(name)
    if name in STOCHASTIC:
        cv2.setRNGSeed(seed)
        # Its features come from the C library's generator.
        ctypes.CDLL("ucrtbase" if os.name == "nt" else None).srand(seed)
    return PEERS[name](cv2)
