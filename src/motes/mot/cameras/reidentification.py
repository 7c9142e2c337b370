"""Who is who among several cameras: targets that leave one are expected at another.

Nummiaro et al., section VII: when a person leaves one room, its camera tells the other room's what
it knows. What it tells is a `ObjectReport`; frames stay where they are.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from motes.core.track import Status
from motes.cues.histogram_cue import bhattacharyya
from motes.mot.assignment import assign
from motes.mot.cameras.camera_report import CameraReport, ObjectReport
from motes.mot.cameras.rig_config import DISTANCE, CameraLink, Rig

Floats = NDArray[np.float64]

CAMERA_TIMEOUT = 1.0
"""A camera that says nothing for more seconds than this was interrupted."""
REIDENTIFICATION_WINDOW = 30.0
"""Seconds for which what an interruption took out of sight is expected in the same camera."""
FRESH = 0.2
"""Two cameras say where an object is at the same time if it is less than so many seconds apart."""
SIZES = 2.0
"""An object is at most so many times higher or lower than expected."""


@dataclass(slots=True, eq=False)
class _Known:
    """An object of a camera: whose identity it has, and when and how it was last seen.

    `interrupted` says that it is out of sight since the camera said nothing for a while, `passed`
    that its identity went on to another object.
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
        """How many objects have come with an identity that another one had before."""

    def update(self, report: CameraReport) -> dict[int, int]:
        """Return the identity in the rig of each of the camera's objects.

        What is out of sight and whose identity has gone on to another object has none any more.
        Reports of different cameras are given in the order of their time.
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
        told = {s.identity: self._known[camera, s.identity] for s in report.sightings}
        found = {own: known.identity for own, known in told.items() if not known.passed}
        self._known = {
            key: known
            for key, known in self._known.items()
            if not known.gone or now - known.seen <= self._memory
        }
        return found

    def _note(self, known: _Known, sighting: ObjectReport, now: float) -> None:
        """Note what a camera tells of an object that it has told of before."""
        known.last = sighting
        if sighting.histogram is not None:
            known.look = _look(sighting)
        known.gone = sighting.status is Status.LOST
        if sighting.seen:
            known.seen, known.tracked, known.interrupted = now, sighting, False
            if known.passed:  # it never left: somebody else came by the other door
                known.identity, known.passed = next(self._identities), False

    def _inherited(self, camera: str, now: float, born: Sequence[ObjectReport]) -> dict[int, int]:
        """Return the identities in the rig of those new objects that were expected."""
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
        """Return how little a new object is like one that is known; infinite where ruled out.

        From 0 to 1 where it stands where that is, from 1 to 2 where that is expected.
        """
        off = min(self._offs(known, camera, born)) if now - known.seen <= FRESH else math.inf
        if off <= 1 or known.last.seen or known.passed:
            return off
        limits = [
            passage.distance
            for passage, first, second in self._ways(known.camera, camera)
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

    def _ways(self, start: str, end: str) -> Iterator[tuple[CameraLink, str, str]]:
        """Yield the passages from one camera to another, and the names of their places there."""
        for passage in self._rig.passage:
            for ends in (passage.between, passage.between[::-1]):
                (first, _, out), (second, _, into) = (each.rpartition("/") for each in ends)
                if (first, second) == (start, end):
                    yield passage, out, into

    def _offs(self, known: _Known, camera: str, born: ObjectReport) -> Iterator[float]:
        """Yield how far a new object is from one that another camera sees, as a share of reach."""
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
    """Return whether an object has the height with which another one is expected."""
    if passage.scale is None:
        return True
    onward = passage.between[1].rpartition("/")[0] == camera
    scale = passage.scale if onward else 1 / passage.scale
    ratio = born.box.height / (scale * known.tracked.box.height)
    return 1 / SIZES <= ratio <= SIZES
