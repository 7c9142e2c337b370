"""Where could targets be? Anything that finds objects in a frame can start a tracker."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol

from motes.errors import LimitError
from motes.frame import Frame
from motes.geometry import Box


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
