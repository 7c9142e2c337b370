"""Settings of a detector in an ONNX file, from the file itself and a TOML file beside it."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

from msgspec import Meta

from motes.core.config import Config, Count, Share, from_toml
from motes.core.detection import DetectorConfig
from motes.core.errors import ConfigError, SourceError

if TYPE_CHECKING:
    from motes.mot.detection.onnx_detector import OnnxDetector

Head = Literal["auto", "yolox", "yolov5", "yolo", "nms", "detr", "rfdetr", "lists"]
Fit = Literal["letterbox", "corner", "stretch"]
Channel = Annotated[float, Meta(gt=0)]


class OnnxConfig(DetectorConfig, Config, frozen=True, tag="onnx"):
    """How a trained detector in an ONNX file is used.

    A TOML file beside it with the same name, such as `model.toml`, may have all keys but `file`.

    Attributes
    ----------
    file
        Path of the ONNX file.
    head
        Form of the model's outputs. Usually they show it (`auto`): `yolox`, `yolov5` (with
        objectness), `yolo` (version 8 and later), `nms` (boxes, scores and classes in six columns),
        `detr` (softmax, no object last), `rfdetr` (sigmoid), `lists` (outputs of boxes, of labels
        and of scores).
    size
        Width and height of the model's input. By default that of the file; 640, 640 if it leaves
        them open.
    fit
        How a frame becomes an input of that size: with gray on two sides (`letterbox`), below and
        on the right (`corner`), or stretched. By default as the head's models do.
    layout
        Whether the channels come before or after rows and columns. By default as in the file.
    order
        The order of the channels. By default as the head's models have it.
    mean, deviation
        From each channel, 0 to 255, the mean is subtracted, and the result is divided by the
        deviation. By default as the head's models have them.
    classes
        Names of the classes, in the order of their numbers. By default the file's, if it names
        them.
    score
        Least score of a detection. With a larger value there are fewer detections.
    overlap
        Of two detections of a class with a larger intersection over union, the one with the lower
        score is left out. Heads that have one detection for each object ignore it.
    threads
        Number of threads. By default one for each core.
    """

    file: str
    head: Head = "auto"
    size: tuple[Count, Count] | None = None
    fit: Fit | None = None
    layout: Literal["nchw", "nhwc"] | None = None
    order: Literal["rgb", "bgr"] | None = None
    mean: tuple[float, float, float] | None = None
    deviation: tuple[Channel, Channel, Channel] | None = None
    classes: tuple[str, ...] = ()
    score: Share = 0.3
    overlap: Share = 0.6
    threads: Count | None = None

    def detector(self) -> OnnxDetector:
        """Return the detector.

        Raises
        ------
        MissingDependencyError
            If onnxruntime is not installed.
        SourceError
            If the file cannot be read, or is no ONNX file.
        ConfigError
            If the form of its outputs is not known.
        """
        from motes.mot.detection.onnx_detector import OnnxDetector

        return OnnxDetector(self)


def onnx_values(file: str) -> dict[str, Any]:
    """Return the values of an `OnnxConfig` for an ONNX file and the TOML file beside it.

    Raises
    ------
    SourceError
        If the TOML file cannot be read.
    ConfigError
        If it is not valid.
    """
    values: dict[str, Any] = {"type": "onnx", "file": file}
    beside = Path(file).with_suffix(".toml")
    if beside.exists():
        try:
            given = from_toml(beside.read_text(encoding="utf-8-sig"), str(beside))
        except (OSError, UnicodeDecodeError) as error:
            reason = error.strerror if isinstance(error, OSError) else "it is no text"
            raise SourceError(f"{beside} cannot be read: {reason}; check the file.") from None
        for key in ("type", "file"):
            if key in given:
                raise ConfigError(f"{beside} has the key {key}, which its name already says.")
        values |= given
    return values
