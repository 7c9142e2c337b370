"""Detectors that are trained already: of faces, of people, and files of detections."""

from __future__ import annotations

import math
from itertools import pairwise
from pathlib import Path

import numpy as np

from motes.core.callables import optional
from motes.core.config import Config
from motes.core.detection import Detection, Detector, DetectorConfig, usable
from motes.core.errors import SourceError
from motes.core.files import lines_of, read_text
from motes.core.frame import Frame
from motes.core.geometry import Box

UPSAMPLE = 1
"""How often pictures are doubled before faces are searched: the smallest have 40 pixels then, 80
without it."""
LEAST_FACE, LEAST_PERSON = 0.0, 0.5
"""Least scores of detections: distances from the classifiers' boundaries. The key
`detections.least` asks for more."""
FEW = 5
"""Frames with detections; fewer do not tell in which frames a detector has looked for them."""

NOTHING = ("-1", "-1.0", "")
"""Numbers after a score that tell nothing."""


class FacesConfig(DetectorConfig, Config, frozen=True, tag="faces"):
    """The detector of faces; it has no settings.

    It finds upright frontal ones, by gradient histograms and a support vector machine: the kind of
    detector of Nummiaro et al., section V, as dlib has trained it.
    """

    def detector(self) -> Detector:
        """Return the detector; raise a MissingDependencyError without dlib."""
        dlib = optional("dlib", "Finding faces needs dlib", "motes[faces]")
        find = dlib.get_frontal_face_detector()

        def faces(frame: Frame) -> list[Detection]:
            boxes, scores, _ = find.run(np.ascontiguousarray(frame.pixels), UPSAMPLE, LEAST_FACE)
            return [
                Detection(Box(r.left(), r.top(), r.width(), r.height()), float(score))
                for r, score in zip(boxes, scores, strict=True)
            ]

        return faces


class PeopleConfig(DetectorConfig, Config, frozen=True, tag="people"):
    """The detector of people; it has no settings.

    It finds upright ones of 100 pixels or more, by gradient histograms and a linear classifier:
    Dalal and Triggs, CVPR 2005; OpenCV contains the trained model.
    """

    def detector(self) -> Detector:
        """Return the detector; raise a MissingDependencyError if OpenCV is missing."""
        cv2 = optional("cv2", "Finding people needs OpenCV", "motes[opencv]")
        find = cv2.HOGDescriptor()
        find.setSVMDetector(np.array(cv2.HOGDescriptor.getDefaultPeopleDetector()))

        def people(frame: Frame) -> list[Detection]:
            if frame.width < 64 or frame.height < 128:  # its window does not fit in
                return []
            boxes, scores = find.detectMultiScale(
                np.ascontiguousarray(frame.pixels),
                hitThreshold=LEAST_PERSON,
                winStride=(8, 8),  # the smallest that OpenCV takes
                scale=1.05,
            )
            # The window has a margin around the person.
            return [
                Detection(Box(x + 0.15 * w, y + 0.07 * h, 0.7 * w, 0.86 * h), score)
                for (x, y, w, h), score in zip(
                    np.reshape(boxes, (-1, 4)).tolist(), np.ravel(scores).tolist(), strict=True
                )
            ]

        return people


class RecordedConfig(DetectorConfig, Config, frozen=True, tag="recorded"):
    """Detections that are read from a file."""

    file: str
    """Path of a text file of detections in the format of the MOTChallenge."""

    def detector(self) -> RecordedDetections:
        """Return its detections; raise a SourceError if the file cannot be read."""
        return RecordedDetections(self.file)


class RecordedDetections:
    """Detections in a file as the MOTChallenge writes them, a line for each.

    Its numbers, between commas, are frame, an identity that is ignored, x, y, width, height, score,
    perhaps more; beside -1 the score may be missing. Frames and pixels count from 1. Those from the
    frame `end` on, at which the run stops, are left out. Raises a SourceError if the file cannot be
    read, or a line is no detection.
    """

    def __init__(self, path: str | Path, end: int | None = None) -> None:
        self._path, self._last, self._apart, self._unfit, self._given = path, 0, 0, 0, 0
        self._frames: dict[int, list[Detection]] = {}
        self._more = False
        for number, line in enumerate(lines_of(read_text(path)), start=1):
            if not line.strip():
                continue
            try:
                fields = line.split(",")
                frame, identity, x, y, width, height, score = map(float, [*fields, "1"][:7])
                sized = 0 < width < 1e6 and 0 < height < 1e6
                counted = frame >= 1 and frame.is_integer() and identity.is_integer()
                named = identity == -1 or len(fields) > 6  # else it may be frame,x,y,w,h,score
                if not (counted and named and sized and math.isfinite(x + y + score)):
                    raise ValueError
            except ValueError:
                raise SourceError(
                    f"{path}, line {number}, is not a detection with commas: frame from 1, -1, x, "
                    f"y, width, height, score; got {line[:60]!r}."
                ) from None
            self._more |= any(each.strip() not in NOTHING for each in fields[7:])
            found = Detection(Box(x - 1, y - 1, width, height), score)
            self._frames.setdefault(int(frame) - 1, []).append(found)
        if not self._frames:
            raise SourceError(f"{path} has no detections; give a file that has some.")
        self._first = min(self._frames)
        if end is not None:
            self._frames = {index: each for index, each in self._frames.items() if index < end}

    def __call__(self, frame: Frame) -> list[Detection]:
        """Return the detections that the file has for a frame."""
        found = self._frames.get(frame.index, [])
        self._apart, self._last = frame.index - self._last, frame.index
        self._given += len(found)
        self._unfit += sum(not usable(each, frame) for each in found)
        return found

    @property
    def unused_detections(self) -> list[str]:
        """Lines on those that could not be used in the frames so far, and on frames without any."""
        if not self._given:
            return [
                f"{self._path} has no detections in the frames up to {self._last} that were used; "
                f"its first ones are of frame {self._first}"
            ]
        end = self._last + max(1, self._apart)  # those of frames that are left out are not missed
        late = sum(len(found) for index, found in self._frames.items() if index >= end)
        why = f"{self._unfit} out of the picture or unfit in size, {late} after frame {self._last}"
        unused, every = self._unfit + late, sum(map(len, self._frames.values()))
        text = f"{unused} of {every} detections of {self._path} were not used: {why}"
        apart = math.gcd(*(index - self._first for index in self._frames))
        start = f" --start {self._first}" * (apart > 0 and self._first % apart > 0)
        rare = (
            f"{self._path} has detections in one frame of {apart} alone, and says that nobody is "
            f"in those between; if none was looked for there, give --set detections.every={apart}"
            f"{start}"
        )
        told = apart > 1 == self._apart and len(self._frames) >= FEW
        order = sorted(self._frames)
        rest = self._last - order[-1]
        ends = (
            f"the last detections of {self._path} are of frame {order[-1]}, and {rest} frames come "
            f"after it; if its detector stopped there, or saw fewer frames, make the file anew"
        )
        pauses = (after - before for before, after in pairwise(order))
        short = len(order) >= FEW and rest > max(self._last / 10, *pauses)
        more = f"the numbers after the score in {self._path}, classes or places, are not read"
        return [text] * (unused > 0) + [rare] * told + [ends] * short + [more] * self._more
