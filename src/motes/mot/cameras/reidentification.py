"""Who is who among several cameras: targets that leave one are expected at another.

Nummiaro et al., section VII: when a person leaves one room, its camera tells the other room's what
it knows. What it tells is a `ObjectReport`; frames stay where they are.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import msgspec
import numpy as np
from numpy.typing import NDArray

from motes.core.config import Config, NonNegative, Positive, Share, from_dict, from_toml
from motes.core.errors import ConfigError
from motes.core.geometry import Box
from motes.core.track import Status
from motes.cues.histogram_cue import bhattacharyya
from motes.mot.assignment import assign
from motes.sot.known_target import Place

Floats = NDArray[np.float64]
Triple = tuple[float, float, float]

CAMERA_TIMEOUT = 1.0
"""A camera that says nothing for more seconds than this was interrupted."""
REIDENTIFICATION_WINDOW = 30.0
"""Seconds for which what an interruption took out of sight is expected in the same camera."""
FRESH = 0.2
"""Two cameras say where an object is at the same time if it is less than so many seconds apart."""
DISTANCE = 0.6
"""Largest distance between color histograms of the same object in two views."""
SIZES = 2.0
"""An object is at most so many times higher or lower than expected."""


class Camera(Config, frozen=True):
    """A camera of a rig.

    Attributes
    ----------
    name
        For rows and messages, and to name its places: "name/place".
    source
        As `motes.open_source` takes it.
    detector, preset
        What finds objects, and the particle filter that follows them, as `motes watch` has them.
    offset
        A recording begins so many seconds after the rig.
    place
        Doors and borders through which objects come and go.
    """

    name: str
    source: str
    detector: str | None = None
    preset: str = "nummiaro:adaptive"
    offset: float = 0.0
    place: tuple[Place, ...] = ()


class CameraLink(Config, frozen=True):
    """A way from a place of one camera to a place of another, and back.

    Attributes
    ----------
    between
        The two places, each as "camera/place".
    seconds
        The least and the most time from when somebody is last seen at one until they are an object
        at the other.
    distance
        Largest distance between their color histograms.
    scale
        How many times higher an object is in the second camera; by default heights do not matter.
    """

    between: tuple[str, str]
    seconds: tuple[NonNegative, Positive]
    distance: Share = DISTANCE
    scale: Positive | None = None

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.seconds[0] >= self.seconds[1]:
            raise ConfigError(
                f"seconds: The least time comes first, then a longer one; got {self.seconds}"
            )


class Overlap(Config, frozen=True):
    """Two cameras that see the same ground.

    Attributes
    ----------
    cameras
        Their names.
    homography
        3x3, row by row: takes points (x, y, 1) of the ground in the first one's picture to those in
        the second one's, up to scale.
    reach
        An object is taken for another one's if it stands no farther from it than so many times the
        width of that, in the second one's picture.
    """

    cameras: tuple[str, str]
    homography: tuple[Triple, Triple, Triple]
    reach: Positive = 1.0

    def __post_init__(self) -> None:
        super().__post_init__()
        matrix = np.array(self.homography)
        if not np.isfinite(matrix).all() or np.linalg.matrix_rank(matrix) < 3:
            raise ConfigError("homography: A matrix that can be inverted is needed, got another")

    def there(self, point: tuple[float, float]) -> tuple[float, float]:
        """Return where a ground point of the first camera is in the second; infinite for never."""
        x, y, w = (np.array(self.homography) @ (*point, 1.0)).tolist()
        return (x / w, y / w) if w else (math.inf, math.inf)


class Rig(Config, frozen=True):
    """Several cameras. In TOML: [[camera]] with [[camera.place]], [[passage]] and [[overlap]].

    Attributes
    ----------
    camera
        The cameras; at least one.
    passage
        The ways between places of two cameras.
    overlap
        The pairs of cameras that see the same ground.
    """

    camera: tuple[Camera, ...]
    passage: tuple[CameraLink, ...] = ()
    overlap: tuple[Overlap, ...] = ()

    def __post_init__(self) -> None:
        super().__post_init__()
        names = [camera.name for camera in self.camera]
        places = [f"{camera.name}/{p.name}" for camera in self.camera for p in camera.place]
        if not names:
            raise ConfigError("A rig needs a [[camera]], got none")
        for known, what in ((names, "cameras"), (places, "places")):
            if len(set(known)) < len(known) or not all(each.split("/")[-1] for each in known):
                raise ConfigError(
                    f"The {what} of a rig need names, each its own; got {', '.join(known)}"
                )
        for known, used in (
            (places, [end for passage in self.passage for end in passage.between]),
            (names, [name for overlap in self.overlap for name in overlap.cameras]),
        ):
            for name in used:
                if name not in known:
                    raise ConfigError(
                        f"A passage or overlap got {name!r}, which is not in this rig; known are "
                        f"{', '.join(known) or 'none'}"
                    )

    @classmethod
    def parse(cls, text: str) -> Rig:
        """Return the rig in a TOML text; raise a ConfigError if it is none."""
        rig: Rig = from_dict(from_toml(text, "this file"), cls)
        return rig


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
