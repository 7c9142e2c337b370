"""Detections, and the interface of detectors."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Protocol, runtime_checkable

from motes.core.errors import ConfigError
from motes.core.frame import Frame
from motes.core.geometry import Box
from motes.core.types import Numbers


@dataclass(frozen=True, slots=True)
class Detection:
    """An object found in a frame."""

    box: Box
    """Where it is. It may be given as any four numbers: `as_detections` makes a `Box` of them."""
    score: float = 1.0
    """A larger score is more certain, on any scale: that of `detections.least`."""
    label: str | None = None
    """The name of its class, such as "car"; None if the detector knows no classes."""

    if TYPE_CHECKING:

        def __init__(self, box: Numbers, score: float = 1.0, label: str | None = None) -> None: ...


class Detector(Protocol):
    """Any callable from a frame to the objects found in it.

    A detector may also be a `PreparedDetector` or an `ObservingDetector`. It may have `warnings`,
    texts by their kind; `motion`, the homography (3, 3) of the background from the frame before to
    the latest one, or None; and `unused_detections`, lines for the end of `motes watch`.
    """

    def __call__(self, frame: Frame, /) -> Any:
        """Return the detections in a frame, in any order, in a form of `as_detections`."""
        ...


@runtime_checkable
class PreparedDetector(Protocol):
    """A detector that can see a film's begin before it is asked for objects in the first frame."""

    def prepare(self, frames: Iterable[Frame]) -> None:
        """Learn from the frames of a film, from the first on; reads no more of them than needed."""
        ...


@runtime_checkable
class ObservingDetector(Protocol):
    """A detector that learns which of its detections are objects."""

    def observe(self, moved: Sequence[Box]) -> None:
        """Take the boxes where objects should be that have moved since they were found.

        `Scene` calls it before each frame, with the objects of three frames before, moved on by
        their velocities.
        """
        ...


def abilities(detector: Any) -> dict[str, Any]:
    """Return the methods beside a call that a detector has, by their names.

    What wraps a detector takes them as attributes of its own: Python 3.12 asks no `__getattr__`
    whether an object fulfills a protocol.
    """
    names = ("prepare", "observe")
    return {name: getattr(detector, name) for name in names if hasattr(detector, name)}


class DetectorConfig:
    """The interface of the settings of a detector. They are also a `Config` with a tag."""

    __slots__ = ()

    @abstractmethod
    def detector(self) -> Detector:
        """Return a detector with these settings."""


def check_callable(detector: object) -> None:
    """Raise a ConfigError if a detector cannot be called."""
    if isinstance(detector, type) or not callable(detector):
        raise ConfigError(
            f"A detector is a callable from a Frame to Detections, such as "
            f"motes.BackgroundDetector(); got {detector!r}."
        )


def usable(found: Detection, frame: Frame) -> bool:
    """Return whether a detection can start a tracker.

    Its center lies in the frame, it is no larger than the frame, and at least two pixels wide and
    high.
    """
    x, y, width, height = found.box
    return (
        0 <= x + width / 2 <= frame.width
        and 0 <= y + height / 2 <= frame.height
        and 2 <= width <= frame.width
        and 2 <= height <= frame.height
    )


def best(detections: Sequence[Detection], frame: Frame) -> Detection | None:
    """Return the detection with the highest score that can start a tracker, or None."""
    fitting = [found for found in detections if usable(found, frame)]
    return max(fitting, key=lambda found: found.score, default=None)
