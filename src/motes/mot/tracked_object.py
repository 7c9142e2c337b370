"""One of a scene's objects: what is known of it, how it moves, is seen, hides and ends."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any, Self

import numpy as np
from msgspec.structs import replace
from numpy.typing import NDArray

from motes.core.frame import Frame
from motes.core.geometry import Box, Ellipse
from motes.core.track import Status, Track, finite
from motes.cues.hog import HogModel
from motes.sot.filtering.fusion import fuse_distances
from motes.sot.particle_filter import ParticleFilter
from motes.sot.particle_state import FilterState

Floats = NDArray[np.float64]


@dataclass(frozen=True, slots=True, eq=False)
class SceneTrack:
    """An object in a frame.

    Attributes
    ----------
    identity
        From 1 up; the same from entry to exit, and never used twice.
    track
        Where it is. While it is `occluded`, that is only foreseen, with confidence 0; in its last
        frame it is `lost`.
    occluded_by
        The identity of what hides it, if that is an object.
    detected
        Whether a detection confirms it in this frame.
    """

    identity: int
    track: Track
    occluded_by: int | None = None
    detected: bool = False

    @property
    def box(self) -> Box:
        """The axis-parallel box around the ellipse: x, y, width, height."""
        return self.track.box

    @property
    def xyxy(self) -> tuple[float, float, float, float]:
        """The box as left, top, right and bottom; see `Track.xyxy`."""
        return self.track.xyxy

    def to_dict(self) -> dict[str, Any]:
        """Return the columns of a row file of objects, with values that `json.dumps` takes.

        The keys are frame, time, identity, x, y, width, height, confidence, status and occluded_by;
        x and y are those of the box. Numbers are not rounded; one that is not finite is None.
        """
        each = self.track.to_dict()
        return {
            "frame": each["frame"],
            "time": each["time"],
            "identity": int(self.identity),
            **{name: finite(value) for name, value in self.box._asdict().items()},
            "confidence": each["confidence"],
            "status": each["status"],
            "occluded_by": self.occluded_by,
        }

    def __repr__(self) -> str:
        hidden = "" if self.occluded_by is None else f", occluded_by={self.occluded_by}"
        return f"SceneTrack(identity={self.identity}, {self.track!r}{hidden})"


@dataclass(slots=True, eq=False)
class TrackedObject:
    """What is known of an object.

    Attributes
    ----------
    identity
        From 1 up.
    tracker, rng, state
        What follows it, its random numbers, and where that is.
    track
        Where the object is.
    velocity
        In pixels a second, (2,).
    first_time, last_time
        Times of its first and its last detection.
    detected, occluded_by
        As in `SceneTrack`.
    predicted
        Where it should be in this frame.
    before_observation
        The state before it looked at the frame.
    near_other
        Whether another one is so near that one may hide the other.
    shape_model
        What its edges looked like when the last one came so near.
    occluder_candidate
        The identity of who last hid it, until it is clear which of both is which.
    """

    identity: int
    tracker: ParticleFilter
    rng: np.random.Generator
    state: FilterState
    track: Track
    velocity: Floats
    first_time: float
    last_time: float
    detected: bool = True
    occluded_by: int | None = None
    near_other: bool = False
    shape_model: HogModel | None = None
    occluder_candidate: int | None = None
    before_observation: FilterState = field(init=False)
    predicted: Ellipse = field(init=False)

    @classmethod
    def begin(
        cls,
        identity: int,
        tracker: ParticleFilter,
        rng: np.random.Generator,
        frame: Frame,
        sightings: Sequence[tuple[float, Box]],
    ) -> Self:
        """Return an object that was detected at some times in some boxes, now in the last one."""
        (began, first), (now, last) = sightings[0], sightings[-1]
        start, end = ellipse_from_box(tracker, first), ellipse_from_box(tracker, last)
        state, info = tracker.init(rng, frame, end)
        velocity = np.zeros(2)
        if now > began:
            velocity = (np.array(end[:2]) - start[:2]) / (now - began)
        track = replace(info.track, ellipse=end)
        return cls(identity, tracker, rng, state, track, velocity, began, now)

    @property
    def hidden(self) -> bool:
        """Whether it is there, but not seen."""
        return self.track.status is Status.OCCLUDED

    @property
    def to_track(self) -> SceneTrack:
        """What others are told about it."""
        return SceneTrack(self.identity, self.track, self.occluded_by, self.detected)

    def predict(self, dt: float) -> None:
        """Say where it should be by now, and move its particles there."""
        old, (dx, dy) = self.track.ellipse, (self.velocity * dt).tolist()
        self.predicted = old._replace(x=old.x + dx, y=old.y + dy)
        self._move(old, self.predicted)
        self.detected = False

    def detect(self, box: Box, time: float, steadiness: float = 0.0) -> None:
        """Put it where it is detected; that share of its size is kept of the old."""
        found, old = ellipse_from_box(self.tracker, box), self.predicted
        a = steadiness * old.a + (1 - steadiness) * found.a
        b = steadiness * old.b + (1 - steadiness) * found.b
        ellipse = found._replace(a=a, b=b)
        self._move(old, ellipse)
        self.state = replace(
            self.state, reference_size=ellipse, status=Status.TRACKING, frames_missed=0
        )
        self.track = replace(self.track, ellipse=ellipse, status=Status.TRACKING)
        self.last_time, self.detected, self.occluded_by = time, True, None

    def update_velocity(self, inertia: float, dt: float) -> None:
        """Learn its velocity from how far off the detection is; `inertia` is kept of the old."""
        off = np.array(self.track.ellipse[:2]) - self.predicted[:2]
        self.velocity = self.velocity + (1 - inertia) * off / dt

    def observe(self, frame: Frame, dt: float, *, learn: bool) -> None:
        """Let its filter look at the frame, around where it is detected or should be.

        A detection says where it is; the filter, what it looks like.
        """
        self.before_observation = self.state
        before = replace(self.state, time=frame.time - dt)
        self.state, info = self.tracker.step(self.rng, before, frame)
        if not learn:
            self.state = replace(self.state, models=before.models, memories=before.memories)
        found = self.track.ellipse if self.detected else info.track.ellipse
        self.track = replace(info.track, ellipse=found)
        if self.detected:
            self._move(info.track.ellipse, found)
            self.track = replace(self.track, status=Status.TRACKING)

    @property
    def recognized(self) -> bool:
        """Whether what the filter saw of it in this frame keeps the appearance rule."""
        return self.state.frames_missed == 0 and self.track.status is Status.TRACKING

    def hide(self) -> None:
        """Take back what its filter saw in this frame: it was something else."""
        self.state = self.before_observation
        self.track = replace(self.track, status=Status.OCCLUDED, confidence=0.0)

    def extrapolate(self, frame: Frame) -> None:
        """Go on, hidden, to where it should be."""
        self.track = replace(self.track, frame=frame.index, time=frame.time, ellipse=self.predicted)

    def swap_identity(self, other: TrackedObject) -> None:
        """Be who another one was taken for, and it this one: each stays where it is."""
        mine, theirs = self.state, other.state
        self.state, other.state = _with_target_of(mine, theirs), _with_target_of(theirs, mine)
        self.identity, other.identity = other.identity, self.identity
        self.first_time, other.first_time = other.first_time, self.first_time
        self.shape_model, other.shape_model = other.shape_model, self.shape_model
        self.rng, other.rng = other.rng, self.rng

    def terminate(self) -> None:
        """End."""
        self.track = replace(self.track, status=Status.LOST, confidence=0.0)

    def distances(self, frame: Frame, boxes: Floats) -> Floats:
        """Return how far boxes (m, 4) are from its models: (m,)."""
        ellipses = np.array([Ellipse.from_box(box) for box in boxes.tolist()])
        cues = self.tracker.cues
        each = [
            cue.distances(self.state.models[name], frame, ellipses) for name, cue in cues.items()
        ]
        return fuse_distances(np.array(each), np.full(len(cues), 1 / len(cues)))

    def _move(self, old: Ellipse, new: Ellipse) -> None:
        """Move and resize its particles as a whole; they are at rest then."""
        motion = self.tracker.motion
        ellipses = motion.ellipses(self.state.states).copy()
        ellipses[:, :2] += np.array(new[:2]) - old[:2]
        ellipses[:, 2:4] *= np.array(new[2:4]) / old[2:4]
        self.state = replace(self.state, states=motion.initial(ellipses))


def _with_target_of(here: FilterState, who: FilterState) -> FilterState:
    """Return a state whose target is that of another one."""
    return replace(here, models=who.models, memories=who.memories, backgrounds=who.backgrounds)


def ellipse_from_box(tracker: ParticleFilter, box: Box) -> Ellipse:
    """Return the ellipse in a box as the motion model has it, perhaps turned by 90 degrees."""
    motion = tracker.motion
    upright = np.array([Ellipse.from_box(box)])
    return Ellipse(*motion.ellipses(motion.initial(upright))[0].tolist())
