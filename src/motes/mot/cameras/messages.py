"""The messages between the process of a camera and the main process, beside reports."""

from __future__ import annotations

import msgspec

from motes.mot.cameras.camera_report import Arrival, CameraReport


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
