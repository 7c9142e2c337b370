"""What became of a detection."""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum

from motes.core.detection import Detection


class DetectionOutcome(StrEnum):
    """What became of a detection."""

    MATCHED = "matched"
    """It is the detection of an object that was visible before."""
    FOUND = "found"
    """It is the detection of an object that was occluded before."""
    BORN = "born"
    """It confirms a candidate, which is an object from now on."""
    EXPECTED = "expected"
    """Another camera has announced its object, which begins with it."""
    CANDIDATE = "candidate"
    """It may be an object; the next frames decide."""
    SEVERAL = "several objects"
    """Two or more objects lie in it, as in a blob where they touch, and share it."""
    PART = "part of an object"
    """It lies on an object that has a better detection, or that is followed without one."""
    DOUBLE = "the same as a surer one"
    """It lies on a detection with a higher score, or on a larger one."""
    DOUBTFUL = "doubtful"
    """Its score is among the lowest so far, and these begin no objects."""
    USELESS = "too small, too large or outside"
    """No tracker can start on it."""
    UNWANTED = "of another class, or below the least score"
    """The configuration leaves it out."""
    SURPLUS = "beyond the limit"
    """Its score is too low for the largest number of detections that are used of a frame."""


@dataclass(frozen=True, slots=True)
class LoggedDetection:
    """A detection, what became of it, and the identity of the object that it went to."""

    detection: Detection
    outcome: DetectionOutcome
    identity: int | None = None
