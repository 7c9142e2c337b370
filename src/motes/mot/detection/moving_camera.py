"""Detectors for a camera that moves: they give the camera's motion along with their detections."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from motes.core.detection import Detection, Detector
from motes.core.frame import Frame
from motes.core.geometry import Box
from motes.core.types import Floats
from motes.mot.detection.background import LIMIT, BackgroundConfig, BackgroundDetector
from motes.mot.detection.blobs import blobs
from motes.mot.detection.global_motion import GlobalMotion
from motes.mot.detection.lookalike import LookalikeDetector
from motes.mot.detection.panned_background import PannedBackground


class MovingCamera:
    """Any detector, and the motion of the camera beside it.

    Parameters
    ----------
    detector
        The detector; all that it has can be asked of this one.

    Attributes
    ----------
    motion
        The homography (3, 3) of the background from the last frame to this one, or None.

    Raises
    ------
    MissingDependencyError
        If OpenCV is not installed.
    """

    def __init__(self, detector: Detector) -> None:
        self._detector, self._camera = detector, GlobalMotion()
        self.motion: Floats | None = None

    def __call__(self, frame: Frame) -> Sequence[Detection]:
        """Return the detections in the next frame."""
        self.motion = self._camera.update(frame.pixels)
        return self._detector(frame)

    def __getattr__(self, name: str) -> Any:
        return getattr(self._detector, name)


class PannedDetector:
    """Finds what moves before a background that moves along with the camera (`PannedBackground`).

    Parameters
    ----------
    config
        The settings of a background; `deviations`, `noise`, `trial`, `least` and `most` count.

    Attributes
    ----------
    motion
        The homography (3, 3) of the background from the last frame to this one, or None.

    Raises
    ------
    MissingDependencyError
        If OpenCV is not installed.
    """

    def __init__(self, config: BackgroundConfig = BackgroundConfig()) -> None:  # noqa: B008
        self._config = config
        self._background = PannedBackground(
            config.deviations, config.noise, "similarity", config.trial
        )
        self._moved: Sequence[Box] = ()
        self.motion: Floats | None = None

    def observe(self, moved: Sequence[Box]) -> None:
        """Take the boxes where the objects that have moved should be in the next frame."""
        self._moved = moved

    def __call__(self, frame: Frame) -> list[Detection]:
        """Return the moving objects in the next frame, the largest first, all with the score 1."""
        config = self._config
        pixels = np.ascontiguousarray(frame.pixels)
        mask = self._background.foreground(pixels, frame.time).astype(np.uint8)
        scale = mask.shape[1] / frame.width
        self.motion = self._background.motion
        if self.motion is None or mask.mean() > config.most:
            return []
        found = blobs(mask, config.least, [_scaled(box, scale) for box in self._moved])
        boxes = [_scaled(box, 1 / scale) for box in found[:LIMIT]]
        return [Detection(box) for box in boxes if not self._background.stays(box)]


def _scaled(box: Box, scale: float) -> Box:
    return Box(*(scale * value for value in box))


def before_moving_camera(detector: Detector) -> Detector:
    """Return a detector for a camera that moves, in place of one for a still camera.

    A still background is replaced by one that moves along, with the same settings.

    Raises
    ------
    MissingDependencyError
        If OpenCV is not installed.
    """
    if isinstance(detector, BackgroundDetector):
        return PannedDetector(detector.config)
    if isinstance(detector, LookalikeDetector) and detector.own_background:
        return detector
    return MovingCamera(detector)
