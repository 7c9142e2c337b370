"""From the frames of one camera to reports about the objects in them."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np

from motes import Box, Frame, Place, Scene, Status, Track
from motes.core import Floats
from motes.mot import Expected, Look, intersection_over_first
from motes_fleet.cameras.arrivals import expected_of
from motes_fleet.cameras.camera_report import Arrival, CameraReport, ObjectReport, packed
from motes_fleet.cameras.rig_config import Camera

COMING = 1.0
"""Longest delay, in seconds, of the first report of an object that enters at the border.

It is reported when its whole box is in the frame: a part of a person looks like no expected object.
"""


@dataclass(slots=True)
class _View:
    """What is known of an object."""

    since: float
    """Time of its first frame."""
    places: tuple[str, ...]
    """Names of the places where it was last visible; until it is reported, where it came in."""
    histogram: bytes = b""
    look: bytes = b""
    """Its histogram and its look, as bytes."""
    seen: bool = True
    """Whether it was visible in the last frame."""
    reported: bool = False
    """Whether it has been reported."""


class Doors:
    """The places of a camera, in the pixels of its frames.

    Raises
    ------
    ConfigError
        If a place lies outside the frame.
    """

    def __init__(self, places: Sequence[Place], frame: Frame) -> None:
        self._boxes = {place.name: np.array(place.boxes(frame), np.float64) for place in places}

    def boxes(self, name: str | None) -> Floats:
        """Return the boxes (R, 4) of a place; none without a name."""
        return np.empty((0, 4)) if name is None else self._boxes[name]

    def at(self, box: Box) -> tuple[str, ...]:
        """Return the names of the places that a box touches."""
        one = np.array([box])
        return tuple(
            name for name, boxes in self._boxes.items() if intersection_over_first(one, boxes).any()
        )


class CameraReporter:
    """Turns a camera's frames into reports of the objects that its scene finds and follows.

    The seed is for the samples of expected objects.
    """

    def __init__(self, camera: Camera, scene: Scene, seed: int = 0) -> None:
        self._camera, self._scene, self._seed = camera, scene, seed
        self._arrivals: dict[int, Arrival] = {}
        self._awaited: dict[str, float] = {}
        """The time until which an object is expected, for each place."""
        self._begun: dict[int, int] = {}
        """Identities in the rig of the objects that began as an arrival from an overlap."""
        self._views: dict[int, _View] = {}
        self._doors: Doors | None = None

    def expect(self, arrivals: Iterable[Arrival]) -> None:
        """Expect objects from the next frame on; of an object, the newest arrival counts."""
        for each in arrivals:
            self._arrivals[each.identity] = each
            if each.place is not None:
                self._awaited[each.place] = max(each.until, self._awaited.get(each.place, 0.0))

    def report(self, frame: Frame) -> CameraReport:
        """Return the report of a frame, whose time is that of the rig.

        Raises
        ------
        ConfigError
            If one of the camera's places lies outside the frame.
        SourceError
            If frames change their size.
        """
        if self._doors is None:
            self._doors = Doors(self._camera.place, frame)
        self._scene.expect(self._expected(frame, self._doors))
        tracks = self._scene.update(frame)
        came = {own: self._arrivals.pop(key) for own, key in self._scene.admitted.items()}
        self._begun |= {own: each.identity for own, each in came.items() if each.place is None}
        looks = self._scene.looks
        sightings = [
            self._sighting(frame, each, self._doors, looks.get(each.identity)) for each in tracks
        ]
        reported = tuple(sighting for sighting in sightings if sighting is not None)
        size = frame.width, frame.height
        return CameraReport(self._camera.name, frame.index, frame.time, reported, size)

    def _expected(self, frame: Frame, doors: Doors) -> list[Expected]:
        """Return the objects that are expected in a frame, with samples."""
        self._arrivals = {
            identity: each for identity, each in self._arrivals.items() if frame.time <= each.until
        }
        count = self._scene.config.tracker.particles
        found = []
        for identity, each in self._arrivals.items():
            rng = np.random.default_rng((self._seed, frame.index, identity))
            found.append(expected_of(each, rng, frame.time, doors.boxes(each.place), count))
        return found

    def _sighting(
        self, frame: Frame, each: Track, doors: Doors, clear: Look | None
    ) -> ObjectReport | None:
        """Return the report of an object, or None if it is not reported yet; see `COMING`.

        Its histogram is from the last detection with a whole box; its look is that when it was last
        clear of others, if it ever was.
        """
        seen, whole = each.status is Status.TRACKING, False
        view = self._views.get(each.identity)
        if view is None or seen:
            whole = not each.box.is_cut((frame.width, frame.height))
            places = doors.at(each.box)
            if view is None:
                view = self._views[each.identity] = _View(frame.time, places)
            if view.reported:
                view.places = places
            if not view.reported or (whole and each.detected):
                view.histogram = packed(Expected.CUE.learn(frame, each.ellipse).histogram)
            view.look = packed((clear or Look.at(frame, [each.ellipse])[0]).color)
        appears = not view.reported and seen
        expected = self._begun.get(each.identity)
        waits = bool(view.places) and not whole and frame.time - view.since < COMING
        partial = appears and waits and expected is None
        if partial and not any(
            frame.time <= self._awaited.get(place, -math.inf) for place in view.places
        ):
            return None
        vanishes, view.seen = view.seen and not seen, seen
        if each.gone:
            del self._views[each.identity]
            self._begun.pop(each.identity, None)
        if not (view.reported or seen):
            return None
        view.reported = not partial
        told = seen or vanishes
        return ObjectReport(
            each.identity,
            each.status,
            each.box,
            each.confidence,
            each.occluded_by,
            each.detected,
            view.places,
            view.histogram if told else None,
            each.velocity,
            tuple(each.covariance.ravel().tolist()),
            expected,
            each.label,
            partial,
            each.sought,
            view.look if told else b"",
        )
