"""Adapters for trackers of many objects: the scene, the package trackers, callables, saved results.

`registry.mot_tracker_spec` finds them by name. All get the same detections and give boxes with
identities, 0-based.
"""

from __future__ import annotations

import math
import operator
import time
from abc import abstractmethod
from collections.abc import Callable, Iterable, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from motes import (
    Box,
    ConfigError,
    Detection,
    FormatError,
    Frame,
    MissingDependencyError,
    Scene,
    Status,
    named_detector,
    open_source,
)
from motes.core import as_ellipse, import_callable
from motes_lab.adapters.sot import LARGEST
from motes_lab.datasets.mot_rows import read_rows

PEERS = {
    "trackers:sort": "SORTTracker",
    "trackers:bytetrack": "ByteTrackTracker",
    "trackers:ocsort": "OCSORTTracker",
    "trackers:botsort": "BoTSORTTracker",
    "trackers:cbiou": "CBIoUTracker",
    "trackers:mcbyte": "McByteTracker",
}
"""Names, and the classes of the package `trackers`."""
SEEING = {"trackers:botsort", "trackers:mcbyte"}
"""Those that measure the camera's motion in the frames."""
SCENE = "motes:scene"
"""Name of the scene of motes."""
BACKGROUND = "background"
"""Name of the background detector of motes."""


class SequenceInfo(NamedTuple):
    """The facts that a tracker gets before the first frame."""

    name: str
    """Name of the sequence."""
    frames: int
    rate: float
    """Number of frames, and frames per second."""
    width: int
    height: int
    """Size of a frame, in pixels."""
    source: str | Path | None = None
    """The frames, for a detector that sees the film's begin before (`prepare`)."""


class FoundObject(NamedTuple):
    """An object in a frame: its identity, a whole number that stays the same; box; confidence."""

    identity: int
    box: Box
    confidence: float


class MotAnswer(NamedTuple):
    """The objects that a tracker gives for a frame, and its running time; NaN if unknown."""

    found: list[FoundObject]
    seconds: float


class MotTrackerAdapter:
    """A tracker of all objects of one video."""

    @abstractmethod
    def start(self, info: SequenceInfo) -> None:
        """Prepare for the first frame."""

    @abstractmethod
    def update(self, frame: Frame, detections: Sequence[Detection] | None) -> MotAnswer:
        """Return the objects in a frame; detections are None if the dataset has none."""


class AssociationAdapter(MotTrackerAdapter):
    """A tracker of the package `trackers`, with the default values of the package."""

    def __init__(self, name: str) -> None:
        self._name = name

    def start(self, info: SequenceInfo) -> None:
        """Make a tracker for the frame rate."""
        self._supervision, trackers = import_peers(self._name)
        self._tracker = getattr(trackers, PEERS[self._name])(frame_rate=info.rate)
        self._tracker.reset()  # the class counts identities for all its instances

    def update(self, frame: Frame, detections: Sequence[Detection] | None) -> MotAnswer:
        """Update the tracker with the detections."""
        detections = _require_detections(self._name, detections)
        boxes = np.reshape([found.box for found in detections], (-1, 4))
        given = self._supervision.Detections(
            xyxy=np.hstack([boxes[:, :2], boxes[:, :2] + boxes[:, 2:]]),
            confidence=np.array([found.score for found in detections], np.float64),
            class_id=np.zeros(len(boxes), np.int64),
        )
        seen = [np.ascontiguousarray(frame.pixels[:, :, ::-1])] if self._name in SEEING else []
        start = time.perf_counter()
        answer = self._tracker.update(given, *seen)
        seconds = time.perf_counter() - start
        corners, scores = answer.xyxy.tolist(), np.asarray(answer.confidence, np.float64).tolist()
        return MotAnswer(
            [
                FoundObject(identity + 1, Box(left, top, right - left, bottom - top), score)
                for (left, top, right, bottom), identity, score in zip(
                    corners, answer.tracker_id.astype(np.int64).tolist(), scores, strict=True
                )
                if identity >= 0  # other detections have no track yet
            ],
            seconds,
        )


class SceneAdapter(MotTrackerAdapter):
    """The `Scene` of motes with its default values; occluded objects are not given.

    Parameters
    ----------
    seed
        Seed of its random numbers.
    """

    def __init__(self, seed: int) -> None:
        self._seed = seed

    def start(self, info: SequenceInfo) -> None:
        """Make a scene, whose clock follows the sequence's frame rate."""
        self._rate, self._found = info.rate, list[Detection]()
        self._scene = Scene(lambda _: self._found, seed=self._seed)

    def update(self, frame: Frame, detections: Sequence[Detection] | None) -> MotAnswer:
        """Update the scene."""
        self._found = _require_detections(SCENE, detections)
        picture = Frame(frame.index, frame.index / self._rate, frame.pixels)
        start = time.perf_counter()
        answer = self._scene.update(picture)
        seconds = time.perf_counter() - start
        seen = (each for each in answer if each.status is Status.TRACKING)
        found = [FoundObject(each.identity, each.box, each.confidence) for each in seen]
        return MotAnswer(found, seconds)


class CallableMotAdapter(MotTrackerAdapter):
    """A tracker made by a Python callable; see `registry`.

    Parameters
    ----------
    name
        `module:factory`.
    seed
        The keyword argument `seed` of the call, which follows the `SequenceInfo`; none if None.
    """

    def __init__(self, name: str, seed: int | None = None) -> None:
        self._name, self._factory = name, import_callable(name)
        self._arguments = {} if seed is None else {"seed": seed}

    def start(self, info: SequenceInfo) -> None:
        """Make a tracker."""
        self._tracker = self._factory(info, **self._arguments)
        if not callable(getattr(self._tracker, "update", None)):
            kind = type(self._tracker).__name__
            raise ConfigError(f"{self._name} makes a {kind} without update().")

    def update(self, frame: Frame, detections: Sequence[Detection] | None) -> MotAnswer:
        """Call the tracker and check what it returns."""
        start = time.perf_counter()
        value = self._tracker.update(frame, detections)
        seconds = time.perf_counter() - start
        try:
            found = [_found(*row) for row in value]
        except (ConfigError, TypeError, ValueError):
            raise ConfigError(
                f"update of {self._name} returned {repr(value)[:80]}; it must return a list of "
                f"(id, box, confidence), with a whole number, x, y, width, height, and a number."
            ) from None
        if len({each.identity for each in found}) < len(found):
            raise ConfigError(f"update of {self._name} returned an id twice: {repr(value)[:80]}.")
        return MotAnswer(found, seconds)


def import_peers(name: str) -> tuple[Any, Any]:
    """Return the modules supervision and trackers, for a tracker of `PEERS`.

    Raises
    ------
    MissingDependencyError
        If one of them is not installed, or an older one that does not have the tracker.
    """
    try:
        import supervision
        import trackers
    except ImportError:
        raise MissingDependencyError(
            f"{name} needs the package trackers; install it: pip install 'motes-lab[peers]'."
        ) from None
    if not hasattr(trackers, PEERS[name]):
        raise MissingDependencyError(
            f"{name} is in newer versions of the package trackers; install trackers 2.6 in an "
            f"environment of its own, as it brings another OpenCV."
        )
    return supervision, trackers


def _require_detections(name: str, detections: Sequence[Detection] | None) -> list[Detection]:
    """Return the detections; raise a ConfigError if the dataset has none."""
    if detections is None:
        raise ConfigError(
            f"{name} needs detections, but there is no det/det.txt; name a --detector."
        )
    return list(detections)


def _found(identity: Any, box: Iterable[float], confidence: Any) -> FoundObject:
    """Return an object given by a callable's tracker; a wrong value raises errors of many kinds."""
    region, sure = Box(*map(float, box)), float(confidence)
    as_ellipse(region)
    if not math.isfinite(sure) or max(map(abs, (*region, sure))) > LARGEST:
        raise ValueError("a number is out of bounds")
    return FoundObject(operator.index(identity), region, sure)


class SavedResultsAdapter(MotTrackerAdapter):
    """Results from files: a folder with a file SEQUENCE.txt for each sequence."""

    def __init__(self, folder: Path) -> None:
        self._folder = folder

    def start(self, info: SequenceInfo) -> None:
        """Read the file of the sequence."""
        path = self._folder / f"{info.name}.txt"
        if not path.exists():
            raise FormatError(f"There is no file {path}.")
        self._rows = read_rows(path, info.frames, "results")

    def update(self, frame: Frame, detections: Sequence[Detection] | None) -> MotAnswer:
        """Return the rows of a frame."""
        return MotAnswer([FoundObject(*row) for row in self._rows.listed(frame.index)], math.nan)


class DetectorAdapter(MotTrackerAdapter):
    """A tracker with its own detector, in place of the dataset's detections.

    Parameters
    ----------
    detector
        `background`, `module:callable`, or an ONNX file, as for `motes watch`.
    make
        Makes the tracker, with a seed if it is stochastic.
    seed
        The seed; None if it is not stochastic.
    """

    def __init__(
        self, detector: str, make: Callable[..., MotTrackerAdapter], seed: int | None = None
    ) -> None:
        self._name = detector
        self._detector = named_detector(detector)
        self._adapter = make() if seed is None else make(seed)

    def start(self, info: SequenceInfo) -> None:
        """Start the tracker."""
        if hasattr(self._detector, "prepare") and info.source is not None:
            with open_source(info.source) as film:
                self._detector.prepare(
                    Frame(each.index, each.index / info.rate, each.pixels) for each in film
                )
        self._adapter.start(info)

    def update(self, frame: Frame, detections: Sequence[Detection] | None) -> MotAnswer:
        """Detect objects and update the tracker; only the tracker's time counts."""
        return self._adapter.update(frame, self._detector(frame))
