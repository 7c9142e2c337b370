"""Detectors for a camera that moves: they give the camera's motion along with their detections."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any, Literal, TypeAlias

import numpy as np

from motes.core.detection import Detection, Detector, abilities, as_detections
from motes.core.frame import Frame
from motes.core.geometry import Box
from motes.core.types import Floats
from motes.mot.detection.background import LIMIT, BackgroundConfig, BackgroundDetector
from motes.mot.detection.blobs import blobs
from motes.mot.detection.global_motion import NO_BOXES, GlobalMotion
from motes.mot.detection.lookalike import LookalikeDetector
from motes.mot.detection.morphology import opencv, opencv_warnings
from motes.mot.detection.panned_background import PannedBackground
from motes.mot.overlaps import as_rows

Camera: TypeAlias = Literal["auto", "still", "moving"]
"""What is known of a camera."""

LOOK = 25
"""A camera that stands still is looked at in every such frame."""
STILL = 1 / 640
"""A camera stands still if no corner of its picture moves by more than this share of the width."""
UNSEEN = (
    "Without OpenCV the camera is taken for still, whether it moves or not; install it with: pip "
    "install 'motes[opencv]', or say that it is still: --camera still."
)


class MovingCamera:
    """Any detector, and the motion of the camera beside it.

    A camera of which nothing is known is looked at now and then, and followed while it moves. So
    one that stands still costs little, and what is not exact in a motion does not move its objects.
    Where it is known that it `moves`, it is followed in all frames. All that the detector has can
    be asked of this one. Raises a MissingDependencyError if the camera moves and OpenCV is not
    installed.

    Attributes
    ----------
    motion
        The homography (3, 3) of the background from the last frame to this one, or None.
    """

    def __init__(self, detector: Detector, *, moves: bool = False) -> None:
        self._detector = detector
        vars(self).update(abilities(detector))
        self._camera = GlobalMotion() if moves or opencv() is not None else None
        self._frames, self._followed = 0, math.inf if moves else 0
        self._boxes = NO_BOXES
        self.motion: Floats | None = None

    @property
    def warnings(self) -> Mapping[str, str]:
        """The detector's warnings, and that nobody sees whether the camera moves."""
        unseen = {} if self._camera is not None else {"unseen": UNSEEN, **opencv_warnings()}
        return {**getattr(self._detector, "warnings", {}), **unseen}

    def __call__(self, frame: Frame) -> list[Detection]:
        """Return the detections in the next frame."""
        self.glance(frame)
        found = as_detections(self._detector(frame))
        self._boxes = as_rows(each.box for each in found)
        return found

    def glance(self, frame: Frame) -> None:
        """Look at the camera alone, in a frame at which the detector does not look."""
        self.motion, turn = None, self._frames % LOOK
        self._frames += 1
        if self._camera is None or (turn > 1 and not self._followed):
            return
        if turn == 0 and not self._followed:
            self._camera.forget()  # its last picture is some frames old
        motion = self._camera.update(frame.pixels, self._boxes)
        self._followed = max(self._followed - 1, 0)
        if motion is not None and corner_shifts(motion, frame).max() > STILL:
            self._followed = max(self._followed, 2 * LOOK)
        if self._followed:
            self.motion = motion

    def __getattr__(self, name: str) -> Any:
        if name == "_detector":  # of a copy that is not filled yet
            raise AttributeError(name)
        return getattr(self._detector, name)


def corner_shifts(motion: Floats, frame: Frame) -> Floats:
    """Return how far a motion moves each corner of the picture, as shares of its width: (4,)."""
    corners = np.array([(x, y, 1.0) for x in (0, frame.width) for y in (0, frame.height)])
    moved = corners @ motion.T
    shifts: Floats = np.abs(moved[:, :2] / moved[:, 2:] - corners[:, :2]).max(axis=1) / frame.width
    return shifts


class PannedDetector:
    """Finds what moves before a background that moves along with the camera (`PannedBackground`).

    Of the settings, `deviations`, `noise`, `trial`, `least` and `most` count. Raises a
    MissingDependencyError if OpenCV is not installed.
    """

    def __init__(self, config: BackgroundConfig = BackgroundConfig()) -> None:  # noqa: B008
        self._config = config
        self._background = PannedBackground(
            config.deviations, config.noise, "similarity", config.trial
        )
        self._moved: Sequence[Box] = ()

    @property
    def motion(self) -> Floats | None:
        """The homography (3, 3) of the background from the last frame to this one, or None."""
        return self._background.motion

    def observe(self, moved: Sequence[Box]) -> None:
        """Take the boxes where the objects that have moved should be in the next frame."""
        self._moved = moved

    def glance(self, frame: Frame) -> None:
        """Look at the camera alone, in a frame at which the detector does not look."""
        self._background.glance(frame.pixels)

    def __call__(self, frame: Frame) -> list[Detection]:
        """Return the moving objects in the next frame, the largest first, all with the score 1."""
        config = self._config
        pixels = np.ascontiguousarray(frame.pixels)
        mask = self._background.foreground(pixels, frame.time).astype(np.uint8)
        scale = mask.shape[1] / frame.width
        if mask.all() or mask.mean() > config.most:
            return []
        found = blobs(mask, config.least, [_scaled(box, scale) for box in self._moved])
        boxes = [_scaled(box, 1 / scale) for box in found[:LIMIT]]
        return [Detection(box) for box in boxes if not self._background.stays(box)]


def _scaled(box: Box, scale: float) -> Box:
    return Box(*(scale * value for value in box))


def before_camera(detector: Detector, camera: Camera) -> Detector:
    """Return a detector that gives a camera's motion, too, for a detector before that camera.

    Before a camera that moves, a still background is replaced by one that moves along, with the
    same settings. One that knows the camera's motion stays as it is. Raises a
    MissingDependencyError if the camera moves and OpenCV is not installed.
    """
    if isinstance(detector, BackgroundDetector):
        return PannedDetector(detector.config) if camera == "moving" else detector
    among = isinstance(detector, LookalikeDetector) and not detector.own_background
    if camera == "still" or (hasattr(detector, "motion") and not among):
        return detector
    return MovingCamera(detector, moves=camera == "moving")
