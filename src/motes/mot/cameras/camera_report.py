"""What a camera sends about a frame."""

from __future__ import annotations

import msgspec

from motes.core.geometry import Box
from motes.core.track import Status


class ObjectReport(msgspec.Struct, frozen=True):
    """What a camera tells of an object in a frame.

    Attributes
    ----------
    identity
        The camera's own; see `motes.SceneTrack`.
    status, box, confidence, occluded_by, detected
        As there; the box is foreseen where the status is not `tracking`.
    places
        Names of the camera's places where it was last seen.
    histogram
        What it looks like, in single precision; sent when it appears and when it goes out of sight.
    """

    identity: int
    status: Status
    box: Box
    confidence: float
    occluded_by: int | None
    detected: bool
    places: tuple[str, ...] = ()
    histogram: bytes | None = None

    @property
    def seen(self) -> bool:
        """Whether it is where its box is beyond doubt: colors alone may follow the wrong thing."""
        return self.detected and self.status is Status.TRACKING

    @property
    def foot(self) -> tuple[float, float]:
        """Where it stands: the middle of its box's lower edge."""
        return self.box.x + (self.box.width - 1) / 2, self.box.y + self.box.height - 1


class CameraReport(msgspec.Struct, frozen=True, tag=True):
    """What a camera tells of a frame: its number, its time in the rig in seconds, its objects."""

    camera: str
    frame: int
    time: float
    sightings: tuple[ObjectReport, ...]
