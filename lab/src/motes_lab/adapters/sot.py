"""Adapters for trackers of one object: motes, OpenCV, Python callables.

`registry.tracker_spec` finds them by name.
"""

from __future__ import annotations

import math
import time
from abc import abstractmethod
from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from motes import Box, ConfigError, Ellipse, Frame, Status, Track, Tracker, TrackerConfig
from motes.core import as_ellipse, import_callable
from motes_lab.adapters.opencv import Peer, peer

LARGEST = 1e9
"""Largest number in a region, in pixels: its square is still a finite, exact enough number."""


Position = tuple[float, float, float]
"""The variance of x, the covariance of x and y, the variance of y, in square pixels."""
UNKNOWN: Position = (math.nan, math.nan, math.nan)


class Answer(NamedTuple):
    """A tracker's output for a frame."""

    ellipse: Ellipse | None
    """The estimate of the target; None if the tracker gives none."""
    confidence: float
    """From 0 to 1; NaN if the tracker gives none."""
    lost: bool
    """Whether the tracker reports that it has lost the target."""
    seconds: float
    """Time inside the tracker, without the preparation of its input."""
    covariance: Position = UNKNOWN
    """Covariance of the ellipse's center; NaN if the tracker gives none."""


class TrackerAdapter:
    """A tracker of one object at a time."""

    @abstractmethod
    def init(self, frame: Frame, box: Box) -> Answer:
        """Start anew on the object in a box."""

    @abstractmethod
    def update(self, frame: Frame) -> Answer:
        """Follow the object into the next frame."""


class MotesAdapter(TrackerAdapter):
    """A tracker of motes."""

    def __init__(self, config: TrackerConfig, seed: int = 0) -> None:
        self._tracker = Tracker(config, seed)

    def init(self, frame: Frame, box: Box) -> Answer:
        """Start the tracker."""
        start = time.perf_counter()
        track = self._tracker.init(frame, box)
        return _answer_of_track(track, _seconds_since(start))

    def update(self, frame: Frame) -> Answer:
        """Update the tracker."""
        start = time.perf_counter()
        track = self._tracker.update(frame)
        return _answer_of_track(track, _seconds_since(start))


class OpenCVAdapter(TrackerAdapter):
    """A tracker of OpenCV, which gets BGR and whole pixels; when lost, it gives no region."""

    def __init__(self, name: str, seed: int = 0) -> None:
        self._name, self._seed = name, seed

    def init(self, frame: Frame, box: Box) -> Answer:
        """Make a tracker and start it."""
        image, whole = _bgr(frame), _pixel_box(box, frame)
        self._tracker: Peer = peer(self._name, self._seed)
        start = time.perf_counter()
        self._tracker.init(image, whole)
        return _found(box, _seconds_since(start))

    def update(self, frame: Frame) -> Answer:
        """Update the tracker."""
        image = _bgr(frame)
        start = time.perf_counter()
        found, box = self._tracker.update(image)
        seconds = _seconds_since(start)
        sound = found and np.isfinite(box).all() and min(box[2:]) > 0
        return _found(Box(*box), seconds) if sound else _lost(seconds)


class CallableAdapter(TrackerAdapter):
    """A tracker made by a Python callable; see `registry`.

    Parameters
    ----------
    name
        `module:factory`.
    seed
        The keyword argument `seed` of the call; none if None.
    """

    def __init__(self, name: str, seed: int | None = None) -> None:
        self._name, self._factory = name, import_callable(name)
        self._arguments = {} if seed is None else {"seed": seed}

    def init(self, frame: Frame, box: Box) -> Answer:
        """Make a tracker and start it."""
        self._tracker = self._factory(**self._arguments)
        for method in ("init", "update"):
            if not callable(getattr(self._tracker, method, None)):
                raise ConfigError(
                    f"{self._name} makes a {type(self._tracker).__name__} without {method}()."
                )
        start = time.perf_counter()
        self._tracker.init(frame.pixels, box)
        return _found(box, _seconds_since(start))

    def update(self, frame: Frame) -> Answer:
        """Call the tracker and check what it returns."""
        start = time.perf_counter()
        value = self._tracker.update(frame.pixels)
        seconds = _seconds_since(start)
        if isinstance(value, Track):
            return _answer_of_track(value, seconds)
        try:
            return _answer_of_value(value, seconds)
        except (ConfigError, TypeError, ValueError):
            raise ConfigError(
                f"update of {self._name} returned {repr(value)[:80]}; it must return a box x, y, "
                f"width, height, or (found, box), or a motes.Track, or None if it is lost."
            ) from None


def _seconds_since(start: float) -> float:
    return time.perf_counter() - start


def _found(box: Box, seconds: float) -> Answer:
    return Answer(_region(box), math.nan, False, seconds)


def _lost(seconds: float) -> Answer:
    return Answer(None, math.nan, True, seconds)


def _answer_of_track(track: Track, seconds: float) -> Answer:
    lost, confidence = track.status is not Status.TRACKING, float(track.confidence)
    if not (math.isnan(confidence) or 0 <= round(confidence, 9) <= 1):
        raise ConfigError(f"A confidence is from 0 to 1; got {confidence:g}.")
    (xx, xy), (_, yy) = track.covariance[:2, :2].tolist()
    # Trackers that have no covariance, such as mean shift, give 0.
    covariance = (xx, xy, yy) if np.any(track.covariance) else UNKNOWN
    return Answer(_region(track.ellipse), confidence, lost, seconds, covariance)


def _answer_of_value(value: Any, seconds: float) -> Answer:
    """Return the answer of a callable's tracker; a wrong value raises errors of many kinds."""
    if value is None:
        return _lost(seconds)
    found, region = value if len(value) == 2 else (True, value)
    if found:
        return Answer(_region(region), math.nan, False, seconds)
    try:
        return Answer(_region(region), math.nan, True, seconds)
    except ConfigError:  # None, or 0, 0, 0, 0: a lost tracker need not give a region
        return _lost(seconds)


def _region(values: Sequence[float]) -> Ellipse:
    """Return a region as an ellipse; raise a ConfigError if its numbers are out of bounds."""
    ellipse = as_ellipse(values)
    if max(map(abs, ellipse)) > LARGEST or min(ellipse.a, ellipse.b) < 1 / LARGEST:
        x, y, width, height = ellipse.box
        raise ConfigError(
            f"A region of {width:g}x{height:g} pixels at {x:g}, {y:g} is not possible."
        )
    return ellipse


def _bgr(frame: Frame) -> NDArray[np.uint8]:
    return np.ascontiguousarray(frame.pixels[:, :, ::-1])


def _pixel_box(box: Box, frame: Frame) -> tuple[int, int, int, int]:
    """Return the nearest box of whole pixels, with at least one pixel, inside the frame."""
    left, width = _span(box.x, box.width, frame.width)
    top, height = _span(box.y, box.height, frame.height)
    return left, top, width, height


def _span(low: float, length: float, size: int) -> tuple[int, int]:
    first = min(max(round(low), 0), size - 1)
    return first, max(min(round(low + length), size) - first, 1)
