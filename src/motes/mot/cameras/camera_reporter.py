"""From the frames of one camera to reports about the objects in them."""

from __future__ import annotations

from dataclasses import dataclass

import msgspec
import numpy as np
from numpy.typing import NDArray

from motes.core.frame import Frame
from motes.core.geometry import Box
from motes.core.track import Status
from motes.cues.color import Color
from motes.mot.boxes import intersection_over_first
from motes.mot.cameras.camera_report import CameraReport, ObjectReport
from motes.mot.cameras.rig_config import Camera
from motes.mot.scene import Scene
from motes.mot.tracked_object import SceneTrack

CUE = Color()
"""The cue whose histograms cameras compare."""

COMING = 1.0
"""Longest delay, in seconds, of the first report of an object that enters at the border.

It is reported when its whole box is in the frame: a part of a person looks like no expected object.
"""
MARGIN = 2.0
"""Pixels; a box that is nearer to the border may be cut off by it."""


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


class Ready(msgspec.Struct, frozen=True, tag=True):
    """A camera is open. Live cameras share a clock; recordings are read in the order of time."""

    camera: str
    live: bool


Message = CameraReport | CameraMessage | CameraEnded | Ready


@dataclass(slots=True)
class _View:
    """What is known of an object.

    Attributes
    ----------
    since
        Time of its first frame.
    places
        Names of the places where it was last visible; until it is reported, where it came in.
    look
        Its histogram, as bytes.
    seen
        Whether it was visible in the last frame.
    reported
        Whether it has been reported.
    """

    since: float
    places: tuple[str, ...]
    look: bytes
    seen: bool = True
    reported: bool = False


class CameraReporter:
    """Turns a camera's frames into reports.

    Parameters
    ----------
    camera
        The camera.
    scene
        Its scene, which finds and follows objects.
    """

    def __init__(self, camera: Camera, scene: Scene) -> None:
        self._camera, self._scene = camera, scene
        self._views: dict[int, _View] = {}
        self._places: dict[str, NDArray[np.float64]] | None = None

    def report(self, frame: Frame) -> CameraReport:
        """Return the report of a frame, whose time is that of the rig.

        Raises
        ------
        ConfigError
            If one of the camera's places lies outside the frame.
        SourceError
            If frames change their size.
        """
        if self._places is None:
            self._places = {
                place.name: np.array(place.boxes(frame), np.float64) for place in self._camera.place
            }
        sightings = (self._sighting(frame, track) for track in self._scene.update(frame))
        reported = tuple(sighting for sighting in sightings if sighting is not None)
        return CameraReport(self._camera.name, frame.index, frame.time, reported)

    def _sighting(self, frame: Frame, each: SceneTrack) -> ObjectReport | None:
        """Return the report of an object, or None if it is not reported yet; see `COMING`.

        Its histogram is from the last detection with a whole box.
        """
        track, seen, whole = each.track, each.track.status is Status.TRACKING, False
        view = self._views.get(each.identity)
        if view is None or seen:
            whole = _whole(track.box, frame)
            places = self._at(track.box)
            if view is None:
                view = self._views[each.identity] = _View(frame.time, places, b"")
            if view.reported:
                view.places = places
            if not view.look or (whole and each.detected):
                look = CUE.learn(frame, track.ellipse).histogram
                view.look = look.astype(np.float32).tobytes()
        appears = not view.reported and seen
        if appears and view.places and not whole and frame.time - view.since < COMING:
            return None
        vanishes, view.seen = view.seen and not seen, seen
        if track.status is Status.LOST:
            del self._views[each.identity]
        if not (view.reported or seen):
            return None
        view.reported = True
        return ObjectReport(
            each.identity,
            track.status,
            track.box,
            track.confidence,
            each.occluded_by,
            each.detected,
            view.places,
            view.look if appears or vanishes else None,
        )

    def _at(self, box: Box) -> tuple[str, ...]:
        """Return the names of the places that a box touches."""
        assert self._places is not None
        one = np.array([box])
        return tuple(
            name
            for name, boxes in self._places.items()
            if intersection_over_first(one, boxes).any()
        )


def _whole(box: Box, frame: Frame) -> bool:
    """Return whether the border cuts off no part of a box."""
    right, bottom = box.x + box.width, box.y + box.height
    room = min(box.x, box.y, frame.width - right, frame.height - bottom)
    return room >= MARGIN
