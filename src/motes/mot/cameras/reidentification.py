"""Identities across several cameras: objects that leave one camera are expected at another.

Nummiaro et al., section VII: when a person leaves a room, its camera sends the person's model to
the camera of the other room. Here it sends an `ObjectReport`, and no frames.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from motes.core.track import Status
from motes.core.types import Floats
from motes.cues.histogram_cue import bhattacharyya
from motes.mot.assignment import assign
from motes.mot.cameras.camera_report import CameraReport, ObjectReport
from motes.mot.cameras.rig_config import DISTANCE, CameraLink, Rig

CAMERA_TIMEOUT = 1.0
"""Seconds without a report after which a camera counts as interrupted."""
REIDENTIFICATION_WINDOW = 30.0
"""Seconds for which objects that were visible before an interruption are expected after it."""
FRESH = 0.2
"""Reports of two cameras count as simultaneous up to this many seconds apart."""
SIZES = 2.0
"""Largest ratio of an object's height to the expected height, or of that to it."""


@dataclass(slots=True, eq=False)
class _Known:
    """An object of a camera, and what is known of it.

    Attributes
    ----------
    camera, identity
        The camera's name, and the identity in the rig.
    seen
        Time of its last certain report.
    look
        Its last color histogram.
    last, tracked
        Its last report, and its last certain report.
    gone
        Whether it is lost.
    interrupted
        Whether its camera was interrupted since that certain report.
    passed
        Whether its identity now belongs to another object.
    """

    camera: str
    identity: int
    seen: float
    look: Floats
    last: ObjectReport
    tracked: ObjectReport
    gone: bool = False
    interrupted: bool = False
    passed: bool = False


class CrossCameraAssociation:
    """Gives the objects of several cameras identities that they keep from one to the next.

    Parameters
    ----------
    rig
        How the cameras are joined.
    """

    def __init__(self, rig: Rig) -> None:
        self._rig = rig
        self._known: dict[tuple[str, int], _Known] = {}
        self._times: dict[str, float] = {}
        self._identities = itertools.count(1)
        self._memory = max(
            [REIDENTIFICATION_WINDOW, *(passage.seconds[1] for passage in rig.passage)]
        )
        self.handed = 0
        """How many new objects got the identity of another one."""

    def update(self, report: CameraReport) -> dict[int, int]:
        """Return the identities in the rig of a camera's objects, by those in the camera.

        An object whose identity now belongs to another one has none. Reports of all cameras come in
        the order of their times.
        """
        camera, now = report.camera, report.time
        if now - self._times.get(camera, now) > CAMERA_TIMEOUT:
            for each in self._known.values():
                each.interrupted |= each.camera == camera and not each.gone
        self._times[camera] = now
        born = []
        for sighting in report.sightings:
            known = self._known.get((camera, sighting.identity))
            if known is None:
                born.append(sighting)
            else:
                self._note(known, sighting, now)
        identities = self._inherited(camera, now, born)
        for sighting in born:
            identity = identities.get(sighting.identity) or next(self._identities)
            self._known[camera, sighting.identity] = _Known(
                camera, identity, now, _look(sighting), sighting, sighting
            )
        current = {s.identity: self._known[camera, s.identity] for s in report.sightings}
        found = {own: known.identity for own, known in current.items() if not known.passed}
        self._known = {
            key: known
            for key, known in self._known.items()
            if not known.gone or now - known.seen <= self._memory
        }
        return found

    def _note(self, known: _Known, sighting: ObjectReport, now: float) -> None:
        """Keep the new report of a known object."""
        known.last = sighting
        if sighting.histogram is not None:
            known.look = _look(sighting)
        known.gone = sighting.status is Status.LOST
        if sighting.seen:
            known.seen, known.tracked, known.interrupted = now, sighting, False
            if known.passed:  # it never left: another object came through the other door
                known.identity, known.passed = next(self._identities), False

    def _inherited(self, camera: str, now: float, born: Sequence[ObjectReport]) -> dict[int, int]:
        """Return the identities in the rig of the new objects that were expected."""
        here = {
            known.identity
            for known in self._known.values()
            if known.camera == camera and not (known.gone or known.interrupted)
        }
        costs: dict[int, list[float]] = {}
        for known in self._known.values():
            if known.identity not in here:
                row = costs.setdefault(known.identity, [math.inf] * len(born))
                row[:] = [
                    min(cost, self._cost(known, camera, now, sighting))
                    for cost, sighting in zip(row, born, strict=True)
                ]
        identities = list(costs)
        found: dict[int, int] = {}
        if not born or not costs:
            return found
        for i, j in assign(np.array(list(costs.values()))):
            found[born[j].identity] = identities[i]
            self.handed += 1
            for known in self._known.values():
                known.passed |= known.identity == identities[i] and not known.last.seen
        return found

    def _cost(self, known: _Known, camera: str, now: float, born: ObjectReport) -> float:
        """Return the cost of giving a new object a known one's identity; infinite if ruled out.

        It is from 0 to 1 if an overlapping camera sees the known one in the same place, and from 1
        to 2 if the known one is expected here.
        """
        off = (
            min(self._overlap_distances(known, camera, born))
            if now - known.seen <= FRESH
            else math.inf
        )
        if off <= 1 or known.last.seen or known.passed:
            return off
        limits = [
            passage.distance
            for passage, first, second in self._links(known.camera, camera)
            if first in known.tracked.places
            and second in born.places
            and passage.seconds[0] <= now - known.seen <= passage.seconds[1]
            and _fits(passage, known, camera, born)
        ]
        if (
            known.interrupted
            and known.camera == camera
            and now - known.seen <= REIDENTIFICATION_WINDOW
        ):
            limits.append(DISTANCE)
        if not limits:
            return math.inf
        distance = float(bhattacharyya(_look(born)[None], known.look)[0])
        limit = max(limits)
        return 1 + distance / limit if distance <= limit else math.inf

    def _links(self, start: str, end: str) -> Iterator[tuple[CameraLink, str, str]]:
        """Yield the passages from one camera to another, and the names of their places there."""
        for passage in self._rig.passage:
            for ends in (passage.between, passage.between[::-1]):
                (first, _, out), (second, _, into) = (each.rpartition("/") for each in ends)
                if (first, second) == (start, end):
                    yield passage, out, into

    def _overlap_distances(self, known: _Known, camera: str, born: ObjectReport) -> Iterator[float]:
        """Yield the distances of a new object from one in an overlapping camera, in `reach`."""
        yield math.inf
        for overlap in self._rig.overlap:
            if overlap.cameras == (known.camera, camera):
                off, width = math.dist(overlap.there(known.last.foot), born.foot), born.box.width
            elif overlap.cameras == (camera, known.camera):
                there = overlap.there(born.foot)
                off, width = math.dist(there, known.last.foot), known.last.box.width
            else:
                continue
            share = off / (overlap.reach * width)
            yield share if share <= 1 else math.inf


def _look(sighting: ObjectReport) -> Floats:
    assert sighting.histogram is not None
    return np.frombuffer(sighting.histogram, np.float32).astype(np.float64)


def _fits(passage: CameraLink, known: _Known, camera: str, born: ObjectReport) -> bool:
    """Return whether a new object has the height that is expected of a known one."""
    if passage.scale is None:
        return True
    onward = passage.between[1].rpartition("/")[0] == camera
    scale = passage.scale if onward else 1 / passage.scale
    ratio = born.box.height / (scale * known.tracked.box.height)
    return 1 / SIZES <= ratio <= SIZES
