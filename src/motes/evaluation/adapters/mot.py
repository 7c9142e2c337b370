"""What follows many objects in an evaluation: our scene, peers, callables' trackers, results.

`entries` finds them by name. All get the same detections and give boxes with identities, 0-based.
"""

from __future__ import annotations

import math
import operator
import time
from collections.abc import Callable, Iterable, Sequence
from pathlib import Path
from typing import Any, NamedTuple, Protocol

import numpy as np

from motes.core.detection import Detection, Detector
from motes.core.errors import ConfigError, FormatError, MissingDependencyError
from motes.core.frame import Frame
from motes.core.geometry import Box, as_ellipse
from motes.core.track import Status
from motes.evaluation.adapters.sot import LARGEST, import_factory
from motes.evaluation.datasets.mot_files import read_rows
from motes.mot.boxes import as_rows
from motes.mot.detection.background import BackgroundDetector
from motes.mot.scene import Scene

PEERS = {"trackers:sort": "SORTTracker", "trackers:bytetrack": "ByteTrackTracker"}
"""Names, and the classes of the package `trackers`."""
SCENE = "motes:scene"
"""Name of what motes has."""
BACKGROUND = "background"
"""Name of the detector that motes has."""


class Info(NamedTuple):
    """What a tracker is told before the first frame.

    Attributes
    ----------
    name
        Of the sequence.
    frames, rate
        How many there are, and how many of them a second.
    width, height
        Of a frame, in pixels.
    """

    name: str
    frames: int
    rate: float
    width: int
    height: int


class Found(NamedTuple):
    """An object in a frame: whole number, the same in every frame; box; and confidence."""

    identity: int
    box: Box
    confidence: float


class Said(NamedTuple):
    """What a tracker says about a frame, and how long it took; NaN where that is not known."""

    found: list[Found]
    seconds: float


class MotTrackerAdapter(Protocol):
    """Follows all objects of one video."""

    def start(self, info: Info) -> None:
        """Get ready for the first frame."""
        ...

    def update(self, frame: Frame, detections: Sequence[Detection] | None) -> Said:
        """Say where which objects are; detections are None where the dataset has none."""
        ...

    def close(self) -> None:
        """Let go of everything; there are no calls after that."""
        ...


class Associating:
    """SORT or ByteTrack of the package `trackers`, with the package's values for everything."""

    def __init__(self, name: str) -> None:
        self._name = name

    def start(self, info: Info) -> None:
        """Make a tracker for the frame rate."""
        self._supervision, trackers = peers()
        self._tracker = getattr(trackers, PEERS[self._name])(frame_rate=info.rate)
        self._tracker.reset()  # identities are counted by the class

    def update(self, frame: Frame, detections: Sequence[Detection] | None) -> Said:
        """Ask it."""
        detections = _needed(self._name, detections)
        boxes = as_rows(found.box for found in detections)
        given = self._supervision.Detections(
            xyxy=np.hstack([boxes[:, :2], boxes[:, :2] + boxes[:, 2:]]),
            confidence=np.array([found.score for found in detections], np.float64),
            class_id=np.zeros(len(boxes), np.int64),
        )
        start = time.perf_counter()
        said = self._tracker.update(given)
        seconds = time.perf_counter() - start
        corners, scores = said.xyxy.tolist(), np.asarray(said.confidence, np.float64).tolist()
        return Said(
            [
                Found(identity + 1, Box(left, top, right - left, bottom - top), score)
                for (left, top, right, bottom), identity, score in zip(
                    corners, said.tracker_id.astype(np.int64).tolist(), scores, strict=True
                )
                if identity >= 0  # the others have no track yet
            ],
            seconds,
        )

    def close(self) -> None:
        """Do nothing."""


class Watching:
    """The `Scene` of motes, with its own values; who is hidden is not said.

    Parameters
    ----------
    seed
        Of its random numbers.
    """

    def __init__(self, seed: int) -> None:
        self._seed = seed

    def start(self, info: Info) -> None:
        """Begin a scene, whose clock goes by the sequence's frame rate."""
        self._rate, self._found = info.rate, list[Detection]()
        self._scene = Scene(lambda _: self._found, seed=self._seed)

    def update(self, frame: Frame, detections: Sequence[Detection] | None) -> Said:
        """Ask it."""
        self._found = _needed(SCENE, detections)
        picture = Frame(frame.index, frame.index / self._rate, frame.pixels)
        start = time.perf_counter()
        said = self._scene.update(picture)
        seconds = time.perf_counter() - start
        seen = (each for each in said if each.track.status is Status.TRACKING)
        found = [Found(each.identity, each.track.box, each.track.confidence) for each in seen]
        return Said(found, seconds)

    def close(self) -> None:
        """Do nothing."""


class Made:
    """What a Python callable returns; see `entries`.

    Parameters
    ----------
    name
        `module:factory`.
    seed
        What it is called with, after the `Info`; nothing if that is None.
    """

    def __init__(self, name: str, seed: int | None = None) -> None:
        self._name, self._factory = name, import_factory(name)
        self._arguments = {} if seed is None else {"seed": seed}

    def start(self, info: Info) -> None:
        """Make a tracker."""
        self._tracker = self._factory(info, **self._arguments)
        if not callable(getattr(self._tracker, "update", None)):
            kind = type(self._tracker).__name__
            raise ConfigError(f"{self._name} makes a {kind} without update().")

    def update(self, frame: Frame, detections: Sequence[Detection] | None) -> Said:
        """Ask it."""
        start = time.perf_counter()
        value = self._tracker.update(frame, detections)
        seconds = time.perf_counter() - start
        try:
            found = [_found(*row) for row in value]
        except (ConfigError, TypeError, ValueError):
            raise ConfigError(
                f"update of {self._name} returned {repr(value)[:80]}; it returns a list of (id, "
                f"box, confidence), with a whole number, x, y, width, height, and a number."
            ) from None
        if len({each.identity for each in found}) < len(found):
            raise ConfigError(f"update of {self._name} returned an id twice: {repr(value)[:80]}.")
        return Said(found, seconds)

    def close(self) -> None:
        """Do nothing."""


def peers() -> tuple[Any, Any]:
    """Return the modules supervision and trackers; a MissingDependencyError if one is missing."""
    try:
        import supervision
        import trackers
    except ImportError:
        raise MissingDependencyError(
            "SORT and ByteTrack need the package trackers; install it: pip install 'motes[peers]'."
        ) from None
    return supervision, trackers


def _needed(name: str, detections: Sequence[Detection] | None) -> list[Detection]:
    """Return detections; raise a ConfigError if there are none to be had."""
    if detections is None:
        raise ConfigError(
            f"{name} needs detections, but there is no det/det.txt; name a --detector."
        )
    return list(detections)


def _found(identity: Any, box: Iterable[float], confidence: Any) -> Found:
    """Return what a callable's tracker says of an object; raise nearly anything if it cannot be."""
    region, sure = Box(*map(float, box)), float(confidence)
    as_ellipse(region)
    if not math.isfinite(sure) or max(map(abs, (*region, sure))) > LARGEST:
        raise ValueError("a number is out of bounds")
    return Found(operator.index(identity), region, sure)


class Recorded:
    """Results that are there already: a folder with a file SEQUENCE.txt for each sequence."""

    def __init__(self, folder: Path) -> None:
        self._folder = folder

    def start(self, info: Info) -> None:
        """Read the file of the sequence."""
        path = self._folder / f"{info.name}.txt"
        if not path.exists():
            raise FormatError(f"There is no file {path}.")
        self._rows = read_rows(path, info.frames, "results")

    def update(self, frame: Frame, detections: Sequence[Detection] | None) -> Said:
        """Tell what it says."""
        return Said([Found(*row) for row in self._rows.listed(frame.index)], math.nan)

    def close(self) -> None:
        """Do nothing."""


class Detecting:
    """A contestant with a detector of its own, in place of the dataset's detections.

    Parameters
    ----------
    detector
        `background`, or `module:factory`; what that returns finds the objects of a frame.
    make
        Makes the contestant, with a seed if it is stochastic.
    seed
        Nothing if it is not.
    """

    def __init__(
        self, detector: str, make: Callable[..., MotTrackerAdapter], seed: int | None = None
    ) -> None:
        self._name = detector
        self._detector: Detector = (
            BackgroundDetector() if detector == BACKGROUND else import_factory(detector)()
        )
        self._follower = make() if seed is None else make(seed)

    def start(self, info: Info) -> None:
        """Start the contestant."""
        self._follower.start(info)

    def update(self, frame: Frame, detections: Sequence[Detection] | None) -> Said:
        """Find objects, and ask the contestant; only the latter's time counts."""
        return self._follower.update(frame, self._detector(frame))

    def close(self) -> None:
        """Close the contestant."""
        self._follower.close()
