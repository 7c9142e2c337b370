"""A trained detector in an ONNX file, run by onnxruntime."""

from __future__ import annotations

import ast
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray
from PIL import Image

from motes.core.detection import Detection
from motes.core.errors import ConfigError, MissingDependencyError, SourceError
from motes.core.frame import Frame
from motes.core.geometry import iou
from motes.mot.detection.adapters import Names, label_of, to_boxes
from motes.mot.detection.onnx_config import OnnxConfig
from motes.mot.detection.onnx_heads import INPUTS, SUPPRESSED, Boxes, decoded, recognized

OPEN = 640
"""Width and height of an input that the file leaves open, as most detectors are trained."""
GRAY = 114
"""The value of pixels beside a frame in a letterbox, as the YOLO models are trained."""
TYPES = {
    "tensor(float)": np.float32,
    "tensor(float16)": np.float16,
    "tensor(uint8)": np.uint8,
}


class Placement(NamedTuple):
    """Where a frame lies in an input: x = left + scale[0] * (x in the frame), and so on."""

    scale: tuple[float, float]
    left: float
    top: float


class OnnxDetector:
    """Finds the objects that a model has learned. A `Detector`.

    Parameters
    ----------
    config
        The path of an ONNX file, or a configuration.

    Attributes
    ----------
    head
        The form of its outputs.
    classes
        The names of its classes by number.

    Raises
    ------
    MissingDependencyError
        If onnxruntime is not installed.
    SourceError
        If the file cannot be read, or is no ONNX file.
    ConfigError
        If its input or its outputs have no known form.
    """

    def __init__(self, config: OnnxConfig | str) -> None:
        config = OnnxConfig(config) if isinstance(config, str) else config
        self.config = config
        self._session = _session(config)
        pictures, *others = self._session.get_inputs()
        self._name, self._type = pictures.name, TYPES.get(pictures.type)
        shape = pictures.shape
        if self._type is None or len(shape) != 4:
            raise self._error(f"Its input is {pictures.type} of {shape}, no picture")
        channels_last = shape[3] == 3 and shape[1] != 3
        self._channels_last = channels_last if config.layout is None else config.layout == "nhwc"
        high, wide = shape[1:3] if self._channels_last else shape[2:]
        open_size = tuple(side if isinstance(side, int) else OPEN for side in (wide, high))
        self._size: tuple[int, int] = config.size or open_size  # type: ignore[assignment]
        # RT-DETR and its kin also ask for the size in which they give boxes.
        self._also = {
            each.name: np.array([self._size], np.int64)
            for each in others
            if each.type == "tensor(int64)"
        }
        self.classes: Names = config.classes or self._named_classes()
        blank = np.zeros((*self._size[::-1], 3), np.uint8)
        try:
            outputs = self._run(blank.astype(np.float64))
            self.head = recognized(outputs, self._size) if config.head == "auto" else config.head
            decoded(self.head, outputs, self._size)
        except ConfigError as error:
            raise self._error(str(error)) from None
        usual = INPUTS[self.head]
        self._fit, self._order = config.fit or usual.fit, config.order or usual.order
        self._mean = np.array(config.mean or usual.scale[0])
        self._deviation = np.array(config.deviation or usual.scale[1])

    def __call__(self, frame: Frame) -> list[Detection]:
        """Return the objects in a frame, those with the highest scores first."""
        pixels, placement = self._fitted(frame.pixels)
        if self._order == "bgr":
            pixels = pixels[:, :, ::-1]
        found = decoded(self.head, self._run((pixels - self._mean) / self._deviation), self._size)
        order = np.argsort(-found.scores, kind="stable")
        order = order[found.scores[order] >= self.config.score]
        found = Boxes(found.sides[order], found.scores[order], found.classes[order])
        if self.head in SUPPRESSED:
            found = suppressed(found, self.config.overlap)
        (across, down), left, top = placement
        sides = (found.sides - (left, top, left, top)) / (across, down, across, down)
        sides = sides.clip(0, (frame.width, frame.height, frame.width, frame.height))
        return [
            Detection(box, score, label_of(number, self.classes))
            for box, score, number in zip(
                to_boxes(sides), found.scores.tolist(), found.classes.tolist(), strict=True
            )
            if box.width > 0 and box.height > 0
        ]

    def _fitted(self, pixels: NDArray[np.uint8]) -> tuple[NDArray[Any], Placement]:
        """Return a frame in the size of the input, and where it lies there."""
        high, wide = pixels.shape[:2]
        scale = self._size[0] / wide, self._size[1] / high
        if self._fit != "stretch":
            scale = (min(scale), min(scale))
        size = max(round(wide * scale[0]), 1), max(round(high * scale[1]), 1)
        if size != (wide, high):
            image = Image.fromarray(np.ascontiguousarray(pixels))
            pixels = np.asarray(image.resize(size, Image.Resampling.BILINEAR))
        if size == self._size:
            return pixels, Placement(scale, 0.0, 0.0)
        room = self._size[0] - size[0], self._size[1] - size[1]
        left, top = (room[0] // 2, room[1] // 2) if self._fit == "letterbox" else (0, 0)
        whole = np.full((*self._size[::-1], 3), GRAY, np.uint8)
        whole[top : top + size[1], left : left + size[0]] = pixels
        return whole, Placement(scale, float(left), float(top))

    def _run(self, pixels: NDArray[np.float64]) -> dict[str, NDArray[Any]]:
        """Return the model's outputs by name, for pixels (H, W, 3) in its units."""
        given = pixels if self._channels_last else np.moveaxis(pixels, 2, 0)
        batch = np.ascontiguousarray(given[None], self._type)
        names = [each.name for each in self._session.get_outputs()]
        try:
            values = self._session.run(names, {self._name: batch, **self._also})
        except Exception as error:  # onnxruntime has errors of many kinds
            raise ConfigError(f"It does not run: {_line(error)}") from None
        return dict(zip(names, values, strict=True))

    def _named_classes(self) -> Names:
        """Return the names of classes in the file's metadata, as Ultralytics writes them."""
        text = self._session.get_modelmeta().custom_metadata_map.get("names", "")
        try:
            names = ast.literal_eval(text)
        except (ValueError, SyntaxError):
            return ()
        if isinstance(names, dict):
            return {int(number): str(name) for number, name in names.items()}
        return [str(name) for name in names] if isinstance(names, list | tuple) else ()

    def _error(self, text: str) -> ConfigError:
        return ConfigError(f"{self.config.file}: {text.rstrip('.')}.")


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


def _session(config: OnnxConfig) -> Any:
    """Return a session of onnxruntime."""
    try:
        import onnxruntime
    except ImportError:
        raise MissingDependencyError(
            "ONNX files need onnxruntime; install it with: pip install 'motes[onnx]'."
        ) from None
    if not Path(config.file).is_file():
        raise SourceError(f"There is no file {config.file}; check the name.")
    options = onnxruntime.SessionOptions()
    options.log_severity_level = 4  # its warnings are not for users
    if config.threads is not None:
        options.intra_op_num_threads = config.threads
    try:
        return onnxruntime.InferenceSession(
            config.file, options, providers=["CPUExecutionProvider"]
        )
    except Exception as error:  # onnxruntime has errors of many kinds
        raise SourceError(f"{config.file} cannot be read as ONNX: {_line(error)}") from None


def _line(error: Exception) -> str:
    return " ".join(str(error).split())[:200].rstrip(".") + "."
