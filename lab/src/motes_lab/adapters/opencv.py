"""OpenCV's trackers for comparison, behind methods like those of `Tracker`.

cv2 is imported only when one of them is used.
"""

from __future__ import annotations

import contextlib
import ctypes
import os
from collections.abc import Callable, Iterator, Sequence
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from motes import ConfigError, MissingDependencyError
from motes_lab.adapters.networks import NETWORKS, is_network, network_files, new_network


class Peer(Protocol):
    """A tracker with OpenCV's interface; images are BGR."""

    def init(self, image: NDArray[np.uint8], box: Sequence[int]) -> None:
        """Start on the object in a box (x, y, width, height)."""
        ...

    def update(self, image: NDArray[np.uint8]) -> tuple[bool, Sequence[float]]:
        """Return whether the target was found, and its box."""
        ...


class CamShift:
    """The usual pipeline of OpenCV's CamShift: HSV, back-projection of a hue histogram, CamShift.

    Pixels with saturation under 60 or value under 32 are left out of the histogram, as in OpenCV's
    example.
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
        """Follow the center of mass of the back-projection."""
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

BLAS_THREADS = "OPENBLAS_NUM_THREADS"

STOCHASTIC = frozenset({"cv2:mil"})
"""Trackers that draw random numbers; the others give the same result every time."""


def is_peer(name: str) -> bool:
    """Return whether a name is one of a tracker of OpenCV."""
    return name in PEERS or is_network(name)


def _new(cv2: Any, name: str) -> Peer:
    """Return a new tracker of a name from the module cv2."""
    made: Peer = new_network(cv2, name) if is_network(name) else PEERS[name](cv2)
    return made


@contextlib.contextmanager
def _one_blas_thread() -> Iterator[None]:
    """Let the BLAS library that is loaded meanwhile, and reads this then, have one thread.

    KCF multiplies matrices. With a second thread it takes as long where that has a core of its own,
    and five times as long where it has to wait for one.
    """
    before = os.environ.get(BLAS_THREADS)
    os.environ[BLAS_THREADS] = "1"
    try:
        yield
    finally:
        del os.environ[BLAS_THREADS]
        if before is not None:
            os.environ[BLAS_THREADS] = before


def opencv(name: str) -> Any:
    """Return the module cv2, set to one thread, if it has the tracker of a name.

    Raises
    ------
    ConfigError
        If the name is unknown, or the files of a network cannot be used.
    MissingDependencyError
        If this OpenCV lacks the tracker.
    """
    if not is_peer(name):
        raise ConfigError(f"No peer {name!r}; known are {', '.join([*PEERS, *NETWORKS])}.")
    network_files(name)
    with _one_blas_thread():
        import cv2
    cv2.setNumThreads(1)
    try:
        _new(cv2, name)
    except AttributeError:
        raise MissingDependencyError(
            f"This OpenCV {cv2.__version__} has no {name.partition('=')[0]}; install "
            f"opencv-contrib-python-headless."
        ) from None
    return cv2


def peer(name: str, seed: int = 0) -> Peer:
    """Return a new tracker of OpenCV, on one thread.

    Start it before the next one is made: a stochastic tracker draws from the random numbers of the
    whole process. They are seeded here and used at its start.

    Raises
    ------
    ConfigError, MissingDependencyError
        As `opencv`.
    """
    cv2 = opencv(name)
    if name in STOCHASTIC:
        cv2.setRNGSeed(seed)
        # Its features are drawn by the random generator of the C library.
        ctypes.CDLL("ucrtbase" if os.name == "nt" else None).srand(seed)
    return _new(cv2, name)
