"""From the frames of one camera to reports of the objects in them."""

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
"""What makes the histograms by which cameras know each other's objects."""


COMING = 1.0
"""Seconds for which somebody who comes in by a door at the border is not told of until seen whole.

Half of a person looks like nobody who is expected.
"""


MARGIN = 2.0
"""Pixels; what is as near to the border may go on beyond it."""


class CameraMessage(msgspec.Struct, frozen=True, tag=True):
    """What there is to say about a camera, for people."""

    camera: str
    text: str


class CameraEnded(msgspec.Struct, frozen=True, tag=True):
    """A camera is at its end: how many frames it had and dropped, and what failed, if anything."""

    camera: str
    frames: int
    dropped: int = 0
    failure: str | None = None


class Ready(msgspec.Struct, frozen=True, tag=True):
    """A camera is open. Live ones have the same clock; recordings wait for each other's time."""

    camera: str
    live: bool


Message = CameraReport | CameraMessage | CameraEnded | Ready


@dataclass(slots=True)
class _View:
    """What is known of an object: since when, where and how it was seen, and whether that is told.

    Until it is told of, `places` are those where it came in.
    """

    since: float
    places: tuple[str, ...]
    look: bytes
    seen: bool = True
    told: bool = False


class CameraReporter:
    """Turns a camera's frames into reports.

    Parameters
    ----------
    camera
        Whose frames.
    scene
        What finds and follows the objects in them.
    """

    def __init__(self, camera: Camera, scene: Scene) -> None:
        self._camera, self._scene = camera, scene
        self._views: dict[int, _View] = {}
        self._places: dict[str, NDArray[np.float64]] | None = None

    def report(self, frame: Frame) -> CameraReport:
        """Return what there is to tell of a frame, whose time is that of the rig.

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
        told = tuple(sighting for sighting in sightings if sighting is not None)
        return CameraReport(self._camera.name, frame.index, frame.time, told)

    def _sighting(self, frame: Frame, each: SceneTrack) -> ObjectReport | None:
        """Return what to tell of an object, None for nothing; see `COMING`.

        Its histogram is that of its last whole view.
        """
        track, seen, whole = each.track, each.track.status is Status.TRACKING, False
        view = self._views.get(each.identity)
        if view is None or seen:
            whole = _whole(track.box, frame)
            places = self._at(track.box)
            if view is None:
                view = self._views[each.identity] = _View(frame.time, places, b"")
            if view.told:
                view.places = places
            if not view.look or (whole and each.detected):
                look = CUE.learn(frame, track.ellipse).histogram
                view.look = look.astype(np.float32).tobytes()
        appears = not view.told and seen
        if appears and view.places and not whole and frame.time - view.since < COMING:
            return None
        vanishes, view.seen = view.seen and not seen, seen
        if track.status is Status.LOST:
            del self._views[each.identity]
        if not (view.told or seen):
            return None
        view.told = True
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
    """Return whether all of a box is in the frame, and not cut off by its border."""
    right, bottom = box.x + box.width, box.y + box.height
    room = min(box.x, box.y, frame.width - right, frame.height - bottom)
    return room >= MARGIN
