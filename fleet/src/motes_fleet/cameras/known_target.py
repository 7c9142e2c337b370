"""A camera of a rig that waits for one known target: Nummiaro et al., section VII.

"Both trackers are put into the initialization mode and will start tracking as soon as a person
enters their field of view."
"""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from motes import Ellipse, Frame, KnownTarget, Status, Track, Tracker, preset
from motes.mot import Expected
from motes_fleet.cameras.arrivals import expected_of
from motes_fleet.cameras.camera_report import Arrival, CameraReport, ObjectReport, packed
from motes_fleet.cameras.camera_reporter import Doors
from motes_fleet.cameras.rig_config import Camera

PRESET = "nummiaro"
"""The preset of the filters: the paper's, whose target model stays as it is."""
SPEED_OVER = 0.2
"""Seconds over which the velocity is measured."""


class KnownTargetReporter:
    """Turns a camera's frames into reports of one known target.

    The tracker searches at the camera's places, or everywhere if it has none, and where another
    camera expects the target.
    """

    def __init__(self, camera: Camera, target: KnownTarget, seed: int = 0) -> None:
        self._camera, self._target, self._seed = camera, target, seed
        self._tracker = Tracker(preset(camera.preset or PRESET), seed)
        self._doors: Doors | None = None
        self._arrivals: tuple[Arrival, ...] = ()
        self._path: list[tuple[float, float, float]] = []
        self._places: tuple[str, ...] = ()

    def start(self, frame: Frame, region: Ellipse) -> None:
        """Begin with the target in a region, as if it had been found there."""
        self._doors = Doors(self._camera.place, frame)
        self._tracker.init(frame, region)

    def expect(self, arrivals: Iterable[Arrival]) -> None:
        """Expect the target from the next frame on."""
        self._arrivals = tuple(arrivals) or self._arrivals

    def report(self, frame: Frame) -> CameraReport:
        """Return the report of a frame, whose time is that of the rig.

        Raises
        ------
        ConfigError
            If the preset cannot search for the target, or a place lies outside the frame.
        SourceError
            If frames change their size.
        """
        if self._doors is None:
            self._doors = Doors(self._camera.place, frame)
            track = self._tracker.search(frame, self._target, self._camera.place)
        else:
            self._look(frame, self._doors)
            track = self._tracker.update(frame)
        sightings: tuple[ObjectReport, ...] = ()
        if track.status in (Status.TRACKING, Status.LOST):
            sightings = (self._sighting(frame, track, self._doors),)
        size = frame.width, frame.height
        return CameraReport(self._camera.name, frame.index, frame.time, sightings, size)

    def _look(self, frame: Frame, doors: Doors) -> None:
        """Give the tracker samples where the target is expected in a frame."""
        self._arrivals = tuple(each for each in self._arrivals if frame.time <= each.until)
        for each in self._arrivals:
            rng = np.random.default_rng((self._seed, frame.index, each.identity))
            boxes = doors.boxes(each.place)
            count = len(self._tracker.info.weights)
            self._tracker.expect(expected_of(each, rng, frame.time, boxes, count).samples)

    def _sighting(self, frame: Frame, track: Track, doors: Doors) -> ObjectReport:
        """Return the report of the target; its identity in the camera is 1."""
        seen = track.status is Status.TRACKING
        if seen:
            self._arrivals, self._places = (), doors.at(track.box)
        x, y = track.ellipse[:2]
        since = frame.time - SPEED_OVER
        self._path = [each for each in self._path if each[0] >= since and seen]
        self._path.append((frame.time, x, y))
        began, *start = self._path[0]
        dt = frame.time - began
        dx, dy = ((x - start[0]) / dt, (y - start[1]) / dt) if dt else (0.0, 0.0)
        look = packed(Expected.CUE.learn(frame, track.ellipse).histogram)
        return ObjectReport(
            1,
            track.status,
            track.box,
            track.confidence,
            None,
            seen,
            self._places,
            look,
            (dx, dy),
            tuple(track.covariance.ravel().tolist()),
        )
