"""The messages between the process of a camera and the main process."""

from __future__ import annotations

import msgspec
import numpy as np

from motes import Box, Ellipse, Status
from motes.core import Floats

Covariance = tuple[float, ...]
"""The 25 numbers of a covariance of x, y, a, b, theta, row by row; none if it is not known."""


def packed(histogram: Floats) -> bytes:
    """Return a histogram in single precision."""
    return histogram.astype(np.float32).tobytes()


def unpacked(histogram: bytes) -> Floats:
    """Return a packed histogram."""
    return np.frombuffer(histogram, np.float32).astype(np.float64)


class ObjectReport(msgspec.Struct, frozen=True):
    """What a camera reports about an object in a frame."""

    identity: int
    """The camera's own; see `motes.Track`."""
    status: Status
    box: Box
    confidence: float
    occluded_by: int | None
    detected: bool
    """As there; unless the status is `tracking`, the box is predicted."""
    places: tuple[str, ...] = ()
    """Names of the camera's places where it was last visible."""
    histogram: bytes | None = None
    """Its model: its color histogram, packed; only when it appears, while it is detected, and when
    it is not visible any more."""
    velocity: tuple[float, float] = (0.0, 0.0)
    """In x and y, in pixels a second."""
    covariance: Covariance = ()
    """Of the ellipse in its box."""
    expected: int | None = None
    """The identity in the rig of the `Arrival` as which it began, if any."""
    label: str | None = None
    """Its class."""
    partial: bool = False
    """Whether it may be a part of an object that is just entering. It is reported only because its
    place expects an object."""
    sought: bool = False
    """As in `motes.Track`."""
    look: bytes = b""
    """Its mean colors in frames in which it was whole and clear of others (`Look.color`), packed;
    with the histogram."""

    @property
    def gone(self) -> bool:
        """Whether the camera reports it no more."""
        return self.status is Status.LOST and not self.sought

    @property
    def seen(self) -> bool:
        """Whether its box is certain: a filter without detections may follow something else."""
        return self.detected and self.status is Status.TRACKING


class CameraReport(msgspec.Struct, frozen=True, tag=True):
    """What a camera reports about a frame."""

    camera: str
    frame: int
    time: float
    """The camera's name, the frame's index, and its time in the rig, in seconds."""
    sightings: tuple[ObjectReport, ...]
    """The objects."""
    size: tuple[int, int] = (0, 0)
    """Width and height of the frame, in pixels."""


class Arrival(msgspec.Struct, frozen=True):
    """An object that one camera has seen and that is expected at another one.

    Nummiaro et al., section VII: "the exact position, velocity and region size could be given to
    the tracker in room A".
    """

    identity: int
    """Its identity in the rig."""
    histogram: bytes
    """Its model, as in `ObjectReport`."""
    ellipse: Ellipse
    velocity: tuple[float, float]
    covariance: Covariance
    """Where it is expected in this camera's picture, at `time`. Of one that is expected at a place
    only the size counts."""
    time: float
    until: float
    """The time of the sample, and the last time at which it is expected."""
    place: str | None = None
    """The name of the place where it is expected; None if it is seen now by an overlapping
    camera."""


class CameraMessage(msgspec.Struct, frozen=True, tag=True):
    """A message about a camera for the user."""

    camera: str
    text: str


class CameraEnded(msgspec.Struct, frozen=True, tag=True):
    """The end of a camera: how many frames it had and dropped, and its failure, if any."""

    camera: str
    frames: int
    dropped: int = 0
    failure: str | None = None


class CameraReady(msgspec.Struct, frozen=True, tag=True):
    """A camera is open. Live cameras share a clock; recordings are read in the order of time."""

    camera: str
    live: bool


class NextFrame(msgspec.Struct, frozen=True, tag=True):
    """A recording has read a frame of this time, in seconds, and waits for its `Go`."""

    time: float


class Go(msgspec.Struct, frozen=True):
    """What a camera may expect from its next frame on. A recording waits for it."""

    arrivals: tuple[Arrival, ...] = ()


Message = CameraReport | CameraMessage | CameraEnded | CameraReady | NextFrame
