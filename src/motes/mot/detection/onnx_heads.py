"""The outputs of trained detectors, as boxes, scores and classes.

| head | outputs, without the first dimension of size 1 | models |
|---|---|---|
| `yolox` | (A, 5 + C): offsets and logarithms of sizes in cells, objectness, classes | YOLOX |
| `yolov5` | (3 A, 5 + C): centers and sizes in pixels, objectness, classes | YOLOv5, YOLOv7 |
| `yolo` | (4 + C, A): centers and sizes in pixels, classes | YOLOv8 and later |
| `nms` | (N, 6): sides in pixels, score, class | YOLOv10, models with their own suppression |
| `detr` | logits (Q, C + 1) for softmax, boxes (Q, 4): centers and sizes from 0 to 1 | DETR |
| `rfdetr` | logits (Q, C) for sigmoid, boxes (Q, 4) likewise | RF-DETR, RT-DETR of transformers |
| `rtdetr` | (Q, 6): boxes likewise, score, class; or (Q, 4 + C): classes | RT-DETR of Ultralytics |
| `lists` | boxes (N, 4): sides in pixels; classes (N,); scores (N,) | torchvision, RT-DETR |

A is the number of cells of grids with steps of 8, 16 and 32 pixels.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, Literal, NamedTuple

import numpy as np
from numpy.typing import NDArray

from motes.core.errors import ConfigError
from motes.core.geometry import iou
from motes.core.onnx_session import Arrays
from motes.core.types import Floats

Head = Literal["auto", "yolox", "yolov5", "yolo", "nms", "detr", "rfdetr", "rtdetr", "lists"]
Fit = Literal["letterbox", "corner", "stretch"]

STEPS = (8, 16, 32)
"""Widths of the cells of grids, in pixels."""
SOFTMAX = ("pred_logits",)
"""Names of outputs that hold logits for softmax, as DETR's export has them."""
IMAGENET = (123.675, 116.28, 103.53), (58.395, 57.12, 57.375)
"""Mean and standard deviation of ImageNet's channels, from 0 to 255."""
UNIT = (0.0, 0.0, 0.0), (255.0, 255.0, 255.0)
RAW = (0.0, 0.0, 0.0), (1.0, 1.0, 1.0)


class Boxes(NamedTuple):
    """Detections in the model's input: sides (N, 4) in pixels, scores (N,), classes (N,)."""

    sides: Floats
    scores: Floats
    classes: NDArray[np.int64]


def recognized(outputs: Arrays, size: tuple[int, int]) -> Head:
    """Return the head of outputs, by their names and shapes.

    Raises a ConfigError if they have none of the known forms.
    """
    shapes = {name: array.shape for name, array in outputs.items()}
    arrays = list(outputs.values())
    cells = len(_cells(size))
    if len(arrays) == 1 and arrays[0].ndim == 3:
        _, rows, columns = arrays[0].shape
        if columns == cells and rows > 4:
            return "yolo"
        if rows == cells and columns > 5:
            return "yolox"
        if rows == 3 * cells and columns > 5:
            return "yolov5"
        if columns == 6:
            return "nms"
    if len(arrays) == 2 and all(array.ndim == 3 for array in arrays):
        boxes, logits = _boxes_and_logits(outputs)
        if boxes is not None and outputs[boxes].shape[1] == outputs[logits].shape[1]:
            return "detr" if logits in SOFTMAX else "rfdetr"
    if len(arrays) == 3 and any(array.dtype.kind in "iu" for array in arrays):
        return "lists"
    found = ", ".join(f"{name} {tuple(shape)}" for name, shape in shapes.items())
    raise ConfigError(
        f"The form of its outputs is not known: {found}; name it with head in a TOML file beside "
        f"it, one of {', '.join(KINDS)}."
    )


def decoded(head: str, outputs: Arrays, size: tuple[int, int]) -> Boxes:
    """Return the detections in outputs of a head, for an input of a width and height.

    Raises a ConfigError if the outputs do not have the head's form, or its scores or boxes cannot
    be those of one.
    """
    try:
        with np.errstate(all="ignore"):  # boxes without an end are no detections
            found = KINDS[head].decode(outputs, size)
    except (ValueError, IndexError, KeyError, TypeError):
        forms = ", ".join(f"{name} {array.shape}" for name, array in outputs.items())
        raise ConfigError(f"Its outputs are not those of head {head}: {forms}.") from None
    finite = np.isfinite(found.sides).all(axis=1)
    found = Boxes(found.sides[finite], found.scores[finite], found.classes[finite])
    low, high = found.scores.min(initial=0).round(2), found.scores.max(initial=1).round(2)
    if low < 0 or high > 1 or (finite.size and not finite.any()):
        raise ConfigError(
            f"Its outputs are not those of head {head}: {finite.sum()} of {finite.size} boxes are "
            f"finite, scores are {low:g} to {high:g}; change head (--set detector.head=NAME)."
        )
    return found


def _yolox(outputs: Arrays, size: tuple[int, int]) -> Boxes:
    rows = _only(outputs)
    cells = _cells(size)
    centers = (rows[:, :2] + cells[:, :2]) * cells[:, 2:]
    sizes = np.exp(rows[:, 2:4]) * cells[:, 2:]
    return _best(_sides(centers, sizes), rows[:, 4:5] * rows[:, 5:])


def _yolov5(outputs: Arrays, size: tuple[int, int]) -> Boxes:
    rows = _only(outputs)
    return _best(_sides(rows[:, :2], rows[:, 2:4]), rows[:, 4:5] * rows[:, 5:])


def _yolo(outputs: Arrays, size: tuple[int, int]) -> Boxes:
    rows = _only(outputs).T
    return _best(_sides(rows[:, :2], rows[:, 2:4]), rows[:, 4:])


def _nms(outputs: Arrays, size: tuple[int, int]) -> Boxes:
    rows = _only(outputs)
    return Boxes(rows[:, :4], rows[:, 4], np.rint(rows[:, 5]).astype(np.int64))


def _detr(outputs: Arrays, size: tuple[int, int]) -> Boxes:
    sides, logits = _queries(outputs, size)
    weights = np.exp(logits - logits.max(axis=1, keepdims=True))
    return _best(sides, (weights / weights.sum(axis=1, keepdims=True))[:, :-1])


def _rfdetr(outputs: Arrays, size: tuple[int, int]) -> Boxes:
    sides, logits = _queries(outputs, size)
    return _best(sides, 0.5 + 0.5 * np.tanh(logits / 2))  # the sigmoid, which cannot overflow


def _rtdetr(outputs: Arrays, size: tuple[int, int]) -> Boxes:
    rows = _only(outputs)
    sides, last = _sides(rows[:, :2] * size, rows[:, 2:4] * size), rows[:, -1]
    if rows.shape[1] == 6 and (last == np.rint(last)).all():  # else of two classes
        return Boxes(sides, rows[:, 4], last.astype(np.int64))
    return _best(sides, rows[:, 4:])


def _lists(outputs: Arrays, size: tuple[int, int]) -> Boxes:
    values = {name: _batch(array, 1) for name, array in outputs.items()}
    [labels] = [name for name, array in outputs.items() if array.dtype.kind in "iu"]
    [boxes] = [name for name, array in values.items() if array.ndim == 2]
    [scores] = [name for name in values if name not in (labels, boxes)]
    return Boxes(
        values[boxes].astype(np.float64),
        values[scores].astype(np.float64),
        values[labels].astype(np.int64),
    )


class Kind(NamedTuple):
    """How models of a head take frames (see `OnnxConfig`), and what they give."""

    decode: Callable[[Arrays, tuple[int, int]], Boxes]
    """Returns the detections in their outputs, for an input of a width and height."""
    fit: Fit
    order: str
    scale: tuple[tuple[float, float, float], tuple[float, float, float]]
    """How they take frames; the scale is the mean and the deviation of the channels."""
    several: bool = False
    """Whether they have several detections of an object."""


KINDS: dict[str, Kind] = {
    "yolox": Kind(_yolox, "corner", "bgr", RAW, several=True),
    "yolov5": Kind(_yolov5, "letterbox", "rgb", UNIT, several=True),
    "yolo": Kind(_yolo, "letterbox", "rgb", UNIT, several=True),
    "nms": Kind(_nms, "letterbox", "rgb", UNIT),
    "detr": Kind(_detr, "stretch", "rgb", IMAGENET),
    "rfdetr": Kind(_rfdetr, "stretch", "rgb", IMAGENET),
    "rtdetr": Kind(_rtdetr, "stretch", "rgb", UNIT),
    "lists": Kind(_lists, "stretch", "rgb", UNIT),
}


def _only(outputs: Arrays) -> Floats:
    """Return the only output, without its first dimension."""
    [array] = outputs.values()
    [rows] = array.astype(np.float64)
    out: Floats = rows
    return out


def _batch(array: NDArray[Any], ndim: int) -> NDArray[Any]:
    """Return an array without a first dimension of 1, if it has one more than it needs."""
    boxes = array.shape[-1] == 4 and array.ndim > 1
    return array[0] if array.ndim > ndim + boxes else array


def _boxes_and_logits(outputs: Arrays) -> tuple[str | None, str]:
    """Return the names of the boxes and of the other output; None for no or two boxes."""
    boxes = [name for name, array in outputs.items() if array.shape[-1] == 4]
    if len(boxes) > 1:  # with four classes the names must show it
        boxes = [name for name in boxes if "box" in name or "det" in name]
    if len(boxes) != 1:
        return None, ""
    [logits] = [name for name in outputs if name != boxes[0]]
    return boxes[0], logits


def _queries(outputs: Arrays, size: tuple[int, int]) -> tuple[Floats, Floats]:
    """Return the sides in pixels and the logits of two outputs."""
    boxes, logits = _boxes_and_logits(outputs)
    if boxes is None:
        raise ValueError("there is no output of boxes")
    [rows], [values] = outputs[boxes].astype(np.float64), outputs[logits].astype(np.float64)
    return _sides(rows[:, :2] * size, rows[:, 2:4] * size), values


def _cells(size: tuple[int, int]) -> Floats:
    """Return the cells of all grids (A, 3): column, row, width in pixels."""
    cells = []
    for step in STEPS:
        row, column = np.mgrid[: size[1] // step, : size[0] // step]
        cells.append(np.stack([column.ravel(), row.ravel(), np.full(row.size, step)], axis=1))
    return np.concatenate(cells).astype(np.float64)


def _sides(centers: Floats, sizes: Floats) -> Floats:
    """Return the sides (N, 4) of boxes with centers and sizes (N, 2)."""
    return np.hstack([centers - sizes / 2, centers + sizes / 2])


def _best(sides: Floats, scores: Floats) -> Boxes:
    """Return each box with its class of the highest score, of scores (N, C)."""
    classes = scores.argmax(axis=1)
    return Boxes(sides, scores[np.arange(len(scores)), classes], classes.astype(np.int64))


def suppressed(found: Boxes, overlap: float) -> Boxes:
    """Return the detections without those that overlap a surer one of the same class too much.

    Detections are sorted, the surest first.
    """
    kept = list[int]()
    boxes = np.hstack([found.sides[:, :2], found.sides[:, 2:] - found.sides[:, :2]])
    for n in range(len(boxes)):
        same = [k for k in kept if found.classes[k] == found.classes[n]]
        if not same or iou(boxes[n], boxes[same]).max() <= overlap:
            kept.append(n)
    return Boxes(found.sides[kept], found.scores[kept], found.classes[kept])
