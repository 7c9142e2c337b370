"""What a camera sends about a frame."""

from __future__ import annotations

import msgspec

from motes.core.geometry import Box
from motes.core.track import Status


class ObjectReport(msgspec.Struct, frozen=True):
    """What a camera reports about an object in a frame.

    Attributes
    ----------
    identity
        The camera's own; see `motes.SceneTrack`.
    status, box, confidence, occluded_by, detected
        As there; unless the status is `tracking`, the box is predicted.
    places
        Names of the camera's places where it was last visible.
    histogram
        Its color histogram, in single precision; only when it appears, and when it is not visible
        any more.
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
        """Whether its box is certain: a filter without detections may follow something else."""
        return self.detected and self.status is Status.TRACKING

    @property
    def foot(self) -> tuple[float, float]:
        """The middle of its box's lower edge."""
        return self.box.x + (self.box.width - 1) / 2, self.box.y + self.box.height - 1


class CameraReport(msgspec.Struct, frozen=True, tag=True):
    """What a camera reports about a frame: its index, its time in the rig (s), its objects."""

    camera: str
    frame: int
    time: float
    sightings: tuple[ObjectReport, ...]
