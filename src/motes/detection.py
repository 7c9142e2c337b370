"""Where could targets be? Anything that finds objects in a frame can start a tracker."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from motes.errors import LimitError
from motes.frame import Frame
from motes.geometry import Box

GAP = (11, 5)
"""Patches of foreground closer than so many rows and columns of pixels are one object."""
LEAST = 0.002
"""Foreground of an object, as a share of the frame.

Of what was tried, these two fit pedestrians best on three sequences of the MOTChallenge: an F1 of
0.55 (PETS09-S2L1), 0.36 (TUD-Stadtmitte) and 0.57 (TUD-Campus) at an overlap (IoU) of half, from
the 30th frame on.
"""
_FOREGROUND = 255
"""In OpenCV's marks; shadows are less."""


@dataclass(frozen=True, slots=True)
class Detection:
    """An object found in a frame: its box, and a score, larger for surer."""

    box: Box
    score: float = 1.0


class Detector(Protocol):
    """Any callable from a frame to the objects found in it."""

    def __call__(self, frame: Frame) -> Sequence[Detection]:
        """Return the detections in a frame, in any order."""
        ...


class FaceDetector:
    """Upright frontal faces, by gradient histograms and a support vector machine.

    The detector class of Nummiaro et al., section V, as dlib ships it, trained; faces of about
    80 pixels and more, or 40 with `upsample` 1.

    Parameters
    ----------
    upsample
        How many times the image's size is doubled before looking.

    Raises
    ------
    LimitError
        If dlib is not installed.
    """

    def __init__(self, upsample: int = 1) -> None:
        try:
            import dlib
        except ImportError:
            raise LimitError(
                "Finding faces needs dlib; install it with: pip install 'motes[faces]'."
            ) from None
        self._find = dlib.get_frontal_face_detector()
        self._upsample = upsample

    def __call__(self, frame: Frame) -> list[Detection]:
        """Return the faces in a frame."""
        boxes, scores, _ = self._find.run(frame.pixels, self._upsample, 0.0)
        return [
            Detection(Box(r.left(), r.top(), r.width(), r.height()), float(score))
            for r, score in zip(boxes, scores, strict=True)
        ]


class BackgroundDetector:
    """What moves before a camera that stands still; it learns the background from the frames.

    A mixture of Gaussians for each pixel, as OpenCV has it (MOG2) with its own values: Zivkovic,
    Improved adaptive Gaussian mixture model for background subtraction, ICPR 2004. Foreground that
    is no shadow makes objects, all with the score 1. Frames come in order; in the first thirty or
    so, what moves leaves ghosts where it was.

    Raises
    ------
    LimitError
        If OpenCV is not installed.
    """

    def __init__(self) -> None:
        try:
            import cv2
        except ImportError:
            raise LimitError(
                "Finding what moves needs OpenCV; install it with: pip install 'motes[opencv]'."
            ) from None
        self._cv2, self._model = cv2, cv2.createBackgroundSubtractorMOG2()

    def __call__(self, frame: Frame) -> list[Detection]:
        """Return what moves in the next frame."""
        cv2, marked = self._cv2, self._model.apply(frame.pixels)
        foreground = (marked == _FOREGROUND).astype(np.uint8)
        closed = cv2.morphologyEx(foreground, cv2.MORPH_CLOSE, np.ones(GAP, np.uint8))
        _, _, found, _ = cv2.connectedComponentsWithStats(closed)
        return [
            Detection(Box(x, y, width, height))
            for x, y, width, height, area in found[1:].tolist()  # the first is the background
            if area >= LEAST * closed.size
        ]


def best(detections: Sequence[Detection], frame: Frame) -> Detection | None:
    """Return the surest detection that can start a tracker, or None.

    Its center lies in the frame, it is no larger than the frame, and at least two pixels wide and
    high.
    """
    fitting = [
        found
        for found in detections
        if 0 <= found.box.x + found.box.width / 2 <= frame.width
        and 0 <= found.box.y + found.box.height / 2 <= frame.height
        and 2 <= found.box.width <= frame.width
        and 2 <= found.box.height <= frame.height
    ]
    return max(fitting, key=lambda found: found.score, default=None)
