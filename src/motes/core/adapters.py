"""Detections in the forms that detectors return them in."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from motes.core.detection import Detection
from motes.core.errors import ConfigError
from motes.core.geometry import Box, in_order
from motes.core.types import Floats

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
