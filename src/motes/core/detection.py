"""Detections, the forms in which detectors return them, and the interface of detectors."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Protocol, runtime_checkable

import numpy as np

from motes.core.errors import ConfigError
from motes.core.frame import Frame
from motes.core.geometry import Box, in_order
from motes.core.types import Floats, Numbers


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
            f"motes.named_detector(); got {detector!r}."
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


Names = Sequence[str] | Mapping[int, str]


def as_detections(value: Any, names: Names = ()) -> list[Detection]:
    """Return detections as `Detection`s.

    Parameters
    ----------
    value
        One of these:

        - a sequence of `Detection`s, whose box may be any four numbers;
        - an array (N, 4), (N, 5) or (N, 6), or a sequence of tuples: x, y, width, height, then
          perhaps the score, then perhaps the class, a number or a name;
        - an object with `xyxy` (N, 4), the left, top, right and lower sides, and perhaps with
          `confidence` (N,) and `class_id` (N,): the `Detections` of supervision.
    names
        Names of the classes by number; a class without a name is called by its number.

    Raises
    ------
    ConfigError
        If it is none of these.
    """
    try:
        if hasattr(value, "xyxy"):
            return _from_sides(value, names)
        return [_from_row(row, names) for row in in_order(value)]
    except (TypeError, ValueError, IndexError, AttributeError, OverflowError):
        raise ConfigError(
            f"The detector returned {' '.join(repr(value).split())[:80]}; it must return a list of "
            f"motes.Detection, rows of x, y, width, height, score, class, or an object with xyxy, "
            f"confidence and class_id."
        ) from None


def to_boxes(sides: Floats) -> list[Box]:
    """Return left, top, right and lower sides (N, 4) as boxes."""
    return [Box(left, top, right - left, low - top) for left, top, right, low in sides.tolist()]


def label_of(number: Any, names: Names) -> str | None:
    """Return the name of a class, given by number or name; None for None."""
    if number is None or isinstance(number, str):
        return number
    index = int(number)
    known = index in names if isinstance(names, Mapping) else 0 <= index < len(names)
    return str(names[index]) if known else str(index)


def class_names(detector: Any) -> list[str]:
    """Return the names of the classes that a detector knows; none if it does not have them."""
    classes: Names = getattr(detector, "classes", ())
    return list(classes.values() if isinstance(classes, Mapping) else classes)


def _from_sides(value: Any, names: Names) -> list[Detection]:
    sides = np.asarray(value.xyxy, np.float64).reshape(-1, 4)
    scores = _column(value, "confidence", len(sides), 1.0)
    named = getattr(value, "data", {}).get("class_name")
    numbers = _column(value, "class_id", len(sides), None) if named is None else list(named)
    return [
        Detection(box, float(score), label_of(str(number) if named is not None else number, names))
        for box, score, number in zip(to_boxes(sides), scores, numbers, strict=True)
    ]


def _column(value: Any, name: str, count: int, usual: Any) -> list[Any]:
    """Return an attribute with a value for each detection; `usual` if it has none."""
    column = getattr(value, name, None)
    return [usual] * count if column is None else np.asarray(column).tolist()


def _from_row(row: Any, names: Names) -> Detection:
    if isinstance(row, Detection):
        box, score, label = row.box, row.score, row.label
        if isinstance(box, Box) and type(score) is float and isinstance(label, str | None):
            return row
        return Detection(Box(*map(float, in_order(box))), float(score), label_of(label, names))
    values = list(in_order(row))
    x, y, width, height = map(float, values[:4])  # fewer or more than six are refused
    score, number = values[4:] + [1.0, None][len(values) - 4 :]
    return Detection(Box(x, y, width, height), float(score), label_of(number, names))
