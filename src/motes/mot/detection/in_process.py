"""A detector in a process of its own, so that its Python code does not wait for the tracking."""

from __future__ import annotations

from contextlib import suppress
from multiprocessing.connection import Connection
from typing import Self

import msgspec
import numpy as np

from motes.core.detection import (
    Detection,
    DetectorConfig,
    ObservingDetector,
    PreparedDetector,
)
from motes.core.errors import ConfigError, MotesError
from motes.core.frame import Frame
from motes.core.geometry import Box
from motes.core.import_callable import explain
from motes.core.worker_processes import blocked_signals, cause, started
from motes.mot.detection.adapters import as_detections, class_names


class _Asked(msgspec.Struct):
    """A frame: its index, its time in seconds, its height and width; its pixels follow."""

    index: int
    time: float
    shape: tuple[int, int]


class _Row(msgspec.Struct, array_like=True):
    """A detection."""

    box: Box
    score: float
    label: str | None


class _Answer(msgspec.Struct):
    """What the detector found, and all its warnings so far; or its classes; or an error."""

    found: list[_Row] = []
    warnings: dict[str, str] = {}
    classes: list[str] = []
    error: str | None = None


class DetectorProcess:
    """Runs a detector in another process. A `Detector` and a context manager.

    A call waits for the answer, so at most one frame is under way; `Scene.watch` calls from a
    thread, while objects are followed in the frames before.

    Parameters
    ----------
    config
        The detector.

    Attributes
    ----------
    warnings
        The detector's warnings so far.
    classes
        The names of the detector's classes, if it knows them.

    Raises
    ------
    ConfigError
        If the detector cannot be made, or learns from the film and the objects in it, as background
        detectors do.
    """

    def __init__(self, config: DetectorConfig) -> None:
        self._process, self._pipe = started(_serve, config)
        self.warnings: dict[str, str] = {}
        self.classes: list[str] = []
        try:
            self.classes = self._answer().classes
        except ConfigError:
            self.close()
            raise

    def __call__(self, frame: Frame) -> list[Detection]:
        """Return what the detector finds in a frame.

        Raises
        ------
        ConfigError
            If the detector fails, or its process ends.
        """
        asked = _Asked(frame.index, frame.time, (frame.height, frame.width))
        with suppress(OSError):  # the answer will be missing, and that is reported
            self._pipe.send_bytes(msgspec.msgpack.encode(asked))
            self._pipe.send_bytes(frame.pixels.tobytes())
        answer = self._answer()
        self.warnings = answer.warnings
        return [Detection(each.box, each.score, each.label) for each in answer.found]

    def _answer(self) -> _Answer:
        try:
            answer = msgspec.msgpack.decode(self._pipe.recv_bytes(), type=_Answer)
        except (EOFError, OSError):
            self._process.join()
            how = cause(self._process.exitcode)
            raise ConfigError(f"The detector's process ended with {how}; start it anew.") from None
        if answer.error is not None:
            raise ConfigError(answer.error)
        return answer

    def close(self) -> None:
        """End the process."""
        with blocked_signals():
            self._process.kill()
            self._process.join()
            self._pipe.close()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()


def _serve(pipe: Connection, config: DetectorConfig) -> None:
    """Make the detector, and answer until the other end of the pipe is closed."""

    def send(answer: _Answer) -> None:
        pipe.send_bytes(msgspec.msgpack.encode(answer))

    with suppress(EOFError, OSError):
        try:
            detector = config.detector()
        except MotesError as error:
            send(_Answer(error=str(error)))
            return
        if isinstance(detector, ObservingDetector | PreparedDetector):
            what = "This detector learns from the film and the objects in it"
            send(_Answer(error=f"{what}, so it cannot run in a process of its own."))
            return
        send(_Answer(classes=class_names(detector)))
        while True:
            asked = msgspec.msgpack.decode(pipe.recv_bytes(), type=_Asked)
            pixels = np.frombuffer(pipe.recv_bytes(), np.uint8).reshape(*asked.shape, 3)
            try:
                found = as_detections(detector(Frame(asked.index, asked.time, pixels)))
            except Exception as error:
                send(_Answer(error=explain(error)))
                continue
            rows = [
                _Row(Box(*map(float, each.box)), float(each.score), each.label) for each in found
            ]
            send(_Answer(rows, dict(getattr(detector, "warnings", {}))))
