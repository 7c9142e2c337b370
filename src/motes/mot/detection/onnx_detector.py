"""A trained detector in an ONNX file."""

from __future__ import annotations

import ast
from pathlib import Path
from typing import Annotated, Any, Literal

import numpy as np
from msgspec import Meta
from numpy.typing import NDArray

from motes.core.config import Config, Count, Share, from_dict, from_toml
from motes.core.detection import Detection, DetectorConfig, Names, label_of, to_boxes
from motes.core.errors import ConfigError
from motes.core.files import read_text
from motes.core.frame import Frame
from motes.core.onnx_session import Arrays, Session
from motes.core.types import Bytes, Floats
from motes.mot.detection.onnx_heads import (
    KINDS,
    Boxes,
    Fit,
    Head,
    decoded,
    recognized,
    suppressed,
)

Channel = Annotated[float, Meta(gt=0)]

OPEN = 640
"""Width and height of an input that the file leaves open, as most detectors are trained."""
GRAY = 114
"""The value of pixels beside a frame in a letterbox, as the YOLO models are trained."""
MODEL = ("head", "description")
"""Keys of the metadata by which Ultralytics' RT-DETR shows; its outputs may look like others."""
TYPES = {"float32": np.float32, "float16": np.float16, "uint8": np.uint8}


class OnnxConfig(DetectorConfig, Config, frozen=True, tag="onnx"):
    """How a trained detector in an ONNX file is used.

    A TOML file beside it with the same name, such as `model.toml`, may have all keys but `file`.
    """

    file: str
    """Path of the ONNX file."""
    head: Head = "auto"
    """Form of the model's outputs. Usually the file shows it (`auto`): `yolox`, `yolov5` (with
    objectness), `yolo` (version 8 and later), `nms` (boxes, scores and classes in six columns),
    `detr` (softmax, no object last), `rfdetr` (sigmoid), `rtdetr` (as Ultralytics exports it),
    `lists` (outputs of boxes, of labels and of scores)."""
    size: tuple[Count, Count] | None = None
    """Width and height of the model's input. By default that of the file; 640, 640 if it does not
    have them."""
    fit: Fit | None = None
    """How a frame becomes an input of that size: with gray on two sides (`letterbox`), below and on
    the right (`corner`), or stretched. By default as the head's models do."""
    layout: Literal["nchw", "nhwc"] | None = None
    """Whether the channels come before or after rows and columns. By default as in the file."""
    order: Literal["rgb", "bgr"] | None = None
    """The order of the channels. By default the one of the head's models."""
    mean: tuple[float, float, float] | None = None
    deviation: tuple[Channel, Channel, Channel] | None = None
    """From each channel, 0 to 255, the mean is subtracted, and the result is divided by the
    deviation. By default those of the head's models."""
    classes: tuple[str, ...] = ()
    """Names of the classes, in the order of their numbers. By default the file's, if it names
    them."""
    score: Share = 0.3
    """Least score of a detection. With a larger value there are fewer detections."""
    overlap: Share = 0.6
    """Largest intersection over union of two detections of a class; with a larger one, that of the
    lower score is left out. Heads that have one detection for each object ignore it."""
    threads: Count | None = None
    """Number of threads. By default one for each core."""

    def detector(self) -> OnnxDetector:
        """Return the detector; raise as it does if the file does not fit."""
        return OnnxDetector(self)


class OnnxDetector:
    """Finds the objects that a model has learned. A `Detector`.

    Raises a MissingDependencyError if ONNX Runtime is not installed; a SourceError if the file
    cannot be read, is no ONNX file, or does not run; and a ConfigError if its input or its outputs
    have no known form.

    Attributes
    ----------
    head
        The form of its outputs.
    classes
        The names of its classes by number.
    """

    def __init__(self, config: OnnxConfig) -> None:
        self.config = config
        self._session = file = Session(config.file, config.threads)
        if not file.inputs or file.inputs[0].type not in TYPES or len(file.inputs[0].shape) != 4:
            raise self._error(f"Its first input is not a picture: {file}")
        (self._name, kind, shape), *others = file.inputs
        self._type = TYPES[kind]
        channels_last = shape[3] == 3 and shape[1] != 3
        self._channels_last = channels_last if config.layout is None else config.layout == "nhwc"
        if (task := file.metadata.get("task", "detect")) != "detect":
            raise self._error(f"It is a model for the task {task}; export one for detect")
        trained = _trained_sides(file.metadata.get("imgsz", ""))
        sides = shape[1:3] if self._channels_last else shape[2:]
        high, wide = (a if isinstance(a, int) else b for a, b in zip(sides, trained, strict=True))
        self._size: tuple[int, int] = config.size or (wide, high)
        # RT-DETR and its kin also ask for the size in which they give boxes.
        self._also = {
            each.name: np.array([self._size], np.int64) for each in others if each.type == "int64"
        }
        self.classes: Names = config.classes or named_classes(file.metadata.get("names", ""))
        blank = np.zeros((*self._size[::-1], 3), np.uint8)
        try:
            outputs = self._run(blank.astype(np.float64))
            self.head = config.head
            if config.head == "auto":
                said = " ".join(file.metadata.get(key, "") for key in MODEL).lower()
                self.head = "rtdetr" if "rtdetr" in said else recognized(outputs, self._size)
            decoded(self.head, outputs, self._size)
        except ConfigError as error:
            raise self._error(str(error)) from None
        usual = KINDS[self.head]
        self._fit, self._order = config.fit or usual.fit, config.order or usual.order
        self._mean = np.array(config.mean or usual.scale[0])
        self._deviation = np.array(config.deviation or usual.scale[1])

    def __call__(self, frame: Frame) -> list[Detection]:
        """Return the objects in a frame, those with the highest scores first."""
        pixels, scale, corner = self._fitted(frame.pixels)
        if self._order == "bgr":
            pixels = pixels[:, :, ::-1]
        found = decoded(self.head, self._run((pixels - self._mean) / self._deviation), self._size)
        order = np.argsort(-found.scores, kind="stable")
        order = order[found.scores[order] >= self.config.score]
        found = Boxes(found.sides[order], found.scores[order], found.classes[order])
        if KINDS[self.head].several:
            found = suppressed(found, self.config.overlap)
        sides = (found.sides - (*corner, *corner)) / (*scale, *scale)
        sides = sides.clip(0, (frame.width, frame.height, frame.width, frame.height))
        return [
            Detection(box, score, label_of(number, self.classes))
            for box, score, number in zip(
                to_boxes(sides), found.scores.tolist(), found.classes.tolist(), strict=True
            )
            if box.width > 0 and box.height > 0
        ]

    def _fitted(self, pixels: Bytes) -> tuple[NDArray[Any], tuple[float, float], tuple[int, int]]:
        """Return a frame in the size of the input; its scale there, and its left upper corner."""
        high, wide = pixels.shape[:2]
        scale = self._size[0] / wide, self._size[1] / high
        if self._fit != "stretch":
            scale = (min(scale), min(scale))
        size = max(round(wide * scale[0]), 1), max(round(high * scale[1]), 1)
        if size != (wide, high):
            from PIL import Image

            image = Image.fromarray(np.ascontiguousarray(pixels))
            pixels = np.asarray(image.resize(size, Image.Resampling.BILINEAR))
        if size == self._size:
            return pixels, scale, (0, 0)
        room = self._size[0] - size[0], self._size[1] - size[1]
        left, top = (room[0] // 2, room[1] // 2) if self._fit == "letterbox" else (0, 0)
        whole = np.full((*self._size[::-1], 3), GRAY, np.uint8)
        whole[top : top + size[1], left : left + size[0]] = pixels
        return whole, scale, (left, top)

    def _run(self, pixels: Floats) -> Arrays:
        """Return the model's outputs by name, for pixels (H, W, 3) in its units."""
        given = pixels if self._channels_last else np.moveaxis(pixels, 2, 0)
        batch = np.ascontiguousarray(given[None], self._type)
        return self._session.run({self._name: batch, **self._also})

    def _error(self, text: str) -> ConfigError:
        return ConfigError(f"{self.config.file}: {text.rstrip('.')}.")


def named_classes(text: str) -> Names:
    """Return the names of classes in a text of the file's metadata, as Ultralytics writes them."""
    names = _literal(text)
    if isinstance(names, dict):
        return {int(number): str(name) for number, name in names.items()}
    return [str(name) for name in names] if isinstance(names, list | tuple) else ()


def _trained_sides(text: str) -> tuple[int, int]:
    """Return height and width in a text of the metadata, as Ultralytics writes them."""
    match _literal(text):
        case [int(high), int(wide)] if high > 0 and wide > 0:
            return high, wide
    return OPEN, OPEN


def _literal(text: str) -> Any:
    """Return the value that a text of the metadata writes as Python does; None if it does not."""
    try:
        return ast.literal_eval(text)
    except (ValueError, SyntaxError):
        return None


def onnx_values(file: str) -> dict[str, Any]:
    """Return the values of an `OnnxConfig` for an ONNX file and the TOML file beside it.

    Raises a SourceError if the TOML file cannot be read, and a ConfigError if it is not valid.
    """
    values: dict[str, Any] = {"type": "onnx", "file": file}
    beside = Path(file).with_suffix(".toml")
    if beside.exists():
        given = from_toml(read_text(beside), str(beside))
        for key in ("type", "file"):
            if key in given:
                raise ConfigError(f"{beside} has the key {key}, which follows from its name.")
        values |= given
        try:
            from_dict(values, OnnxConfig)
        except ConfigError as error:
            raise ConfigError(f"{beside}: {error}") from None
    return values
