"""One of a scene's objects: its filter, its motion, and its status from detection to detection."""

from __future__ import annotations

import math
from collections.abc import Sequence
from functools import cached_property
from typing import Self

import msgspec
import numpy as np
from msgspec.structs import replace

from motes.core.detection import Detection
from motes.core.frame import Frame
from motes.core.geometry import Box, Ellipse
from motes.core.track import Status, Track
from motes.core.types import Floats
from motes.mot.expected import Expected
from motes.mot.hiding import WINDOW, Sighting, hiding_of
from motes.mot.look import Look
from motes.sot.filtering.fusion import fuse_distances
from motes.sot.particle_filter import ParticleFilter
from motes.sot.particle_state import FilterState

CUT = 0.7
"""A detection smaller than this share of an object's size shows a part of it."""
REMEMBERED = 1.0
"""Seconds for which an object may be seen in part until that counts as its size."""
STEADY = 1.0
"""Seconds over which it is counted how steadily an object is detected."""
AT_REST, MOVED, DETECTED = -0.35, 0.43, 2.1
"""Log odds that an object's box overlaps a true one by more than half: of one at rest that is not
detected any more; what it adds to have moved, and to be detected in all frames. A logistic fit over
two sequences with detections, and by the background. Its colors say nothing: those of a bush stay
the same, those of a walker do not."""
FIRST_SURPRISE = 0.25**2
"""How far a detection of a new object is off, squared, in mean half-axes."""


class TrackedObject(msgspec.Struct, frozen=True, eq=False, dict=True):
    """The state of an object. Each method returns the object as it is after a step.

    Only `rng` is not frozen: `observe` draws from it, and each object has its own.
    """

    identity: int
    """From 1 up."""
    tracker: ParticleFilter
    rng: np.random.Generator
    state: FilterState
    """The filter that follows it, its random numbers, and the filter's state."""
    track: Track
    """Where the object is."""
    velocity: Floats
    """In pixels a second, (2,)."""
    last_time: float
    """Time of its last detection."""
    predicted: Ellipse
    """The ellipse where it should be in this frame, by its velocity."""
    before_observation: FilterState
    """The filter's state before the observation of this frame."""
    axes: tuple[float, float]
    """Its half-axes when it was last detected as a whole."""
    detected: bool = True
    occluded_by: int | None = None
    """As in `Track`."""
    known: Look | None = None
    """How it last looked when it was clear of others, before it met those in `met`."""
    seen: Look | None = None
    """How it looks since it is clear of them again."""
    met: frozenset[int] = frozenset()
    """The identities of those that it has met, and may have been mistaken for since."""
    best: float = math.inf
    """The highest score of its detections; infinite if another camera has announced it."""
    votes: dict[str, int] = {}
    """How many of its detections had each class, in the order of their first appearance."""
    origin: tuple[float, float] = (0.0, 0.0)
    """The center of its first detection."""
    moved: bool = False
    """Whether a detection was ever farther from there than its mean half-axis."""
    cut_for: float = 0.0
    """Seconds for which it has been seen in part only, as one that goes behind a wall."""
    hidden_side: int = 0
    """The side on which it is hidden then: -1 is the left one, 1 the right one, 0 unknown."""
    steadiness: float = 0.5
    """Running share of the frames in which it is detected, of those in which it can be seen."""
    recent: tuple[Sighting, ...] = ()
    """Its detections in the last `hiding.WINDOW` seconds, oldest first."""
    surprise: tuple[float, float] = (FIRST_SURPRISE, FIRST_SURPRISE)
    """How far detections were off its predictions: mean squares in x and y, in mean half-axes."""

    @classmethod
    def begin(
        cls,
        identity: int,
        tracker: ParticleFilter,
        rng: np.random.Generator,
        frame: Frame,
        hits: Sequence[tuple[float, Box]],
    ) -> Self:
        """Return a new object from its detections, times and boxes; the last is in this frame."""
        (began, first), (now, last) = hits[0], hits[-1]
        start, end = ellipse_from_box(tracker, first), ellipse_from_box(tracker, last)
        state, info = tracker.init(rng, frame, end)
        velocity = np.zeros(2)
        if now > began:
            velocity = (np.array(end[:2]) - start[:2]) / (now - began)
        track = replace(info.track, ellipse=end)
        return cls(
            identity, tracker, rng, state, track, velocity, now, end, state, end[2:4],
            origin=(start.x, start.y), moved=_far(start, end),
        )  # fmt: skip

    @classmethod
    def take_over(
        cls,
        identity: int,
        tracker: ParticleFilter,
        rng: np.random.Generator,
        frame: Frame,
        expected: Expected,
        box: Box | None,
    ) -> Self | None:
        """Return an expected object whose filter begins with the samples and the model it is given.

        `box` is its detection. Without one it is None, unless the samples fulfill the appearance
        rule.
        """
        colors_only = tracker.cues == {"color": Expected.CUE}
        finder = tracker
        if not colors_only:
            finder = ParticleFilter(
                color=Expected.CUE, motion=tracker.motion, presence=tracker.presence
            )
        state, info = finder.hand_over(frame, {"color": expected.model}, expected.samples)
        if box is None and info.track.status is not Status.TRACKING:
            return None
        if not colors_only:  # other cues learn where the samples match best
            region = info.track.ellipse if box is None else ellipse_from_box(tracker, box)
            state, info = tracker.init(rng, frame, region)
        track = replace(info.track, status=Status.TRACKING)
        begun = cls(
            identity, tracker, rng, state, track, expected.velocity, frame.time, track.ellipse,
            state, track.ellipse[2:4], detected=False, origin=track.ellipse[:2],
        )  # fmt: skip
        return begun if box is None else begun.detect(box, frame.time)

    @cached_property
    def box(self) -> Box:
        """The box of its track, which many stages read."""
        return self.track.box

    @property
    def occluded(self) -> bool:
        """Whether it is there, but cannot be seen."""
        return self.track.status is Status.OCCLUDED

    @property
    def recognized(self) -> bool:
        """Whether the filter's estimate in this frame fulfills the appearance rule."""
        return self.state.frames_missed == 0 and self.track.status is Status.TRACKING

    @property
    def look(self) -> Look | None:
        """How it last looked when it was clear of others, also since it has met some."""
        return self.seen or self.known

    @property
    def found_by_look(self) -> bool:
        """Whether it is known how it looks, so that it is found without a detection."""
        return self.look is not None and self.look.settled

    @property
    def confidence(self) -> float:
        """The probability that its box overlaps a true one by more than half; 0 if it is hidden."""
        if self.track.status is not Status.TRACKING:
            return 0.0
        odds = math.exp(AT_REST + MOVED * self.moved + DETECTED * self.steadiness)
        return odds / (1 + odds)

    @property
    def public_track(self) -> Track:
        """Its track, with all that the scene tells of it."""
        dx, dy = self.velocity.tolist()
        label = max(self.votes, key=self.votes.__getitem__, default=None)
        return replace(
            self.track, identity=self.identity, label=label, occluded_by=self.occluded_by,
            confidence=self.confidence, detected=self.detected, velocity=(dx, dy),
        )  # fmt: skip

    def box_after(self, seconds: float) -> Box:
        """Return the box where it should be some seconds later."""
        box, (dx, dy) = self.box, (self.velocity * seconds).tolist()
        return box._replace(x=box.x + dx, y=box.y + dy)

    def carried(self, place: tuple[float, float], origin: tuple[float, float]) -> Self:
        """Put it, and its origin, where the camera's motion takes them."""
        old = self.track.ellipse
        ellipse = old._replace(x=place[0], y=place[1])
        state = self._moved(self.state, old, ellipse)
        track = replace(self.track, ellipse=ellipse)
        dx, dy = place[0] - old.x, place[1] - old.y
        recent = tuple(
            each._replace(box=each.box._replace(x=each.box.x + dx, y=each.box.y + dy))
            for each in self.recent
        )
        return replace(self, state=state, track=track, origin=origin, recent=recent)

    def predict(self, dt: float) -> Self:
        """Move its particles to where it should be after some seconds."""
        old, (dx, dy) = self.track.ellipse, (self.velocity * dt).tolist()
        predicted = old._replace(x=old.x + dx, y=old.y + dy)
        state = self._moved(self.state, old, predicted)
        cut_for = self.cut_for if self.occluded else self.cut_for + dt
        return replace(self, predicted=predicted, state=state, detected=False, cut_for=cut_for)

    def tallied(self, dt: float) -> Self:
        """Count a frame, some seconds after the last one, in its steadiness; not while hidden."""
        if self.occluded:
            return self
        kept = math.exp(-dt / STEADY)
        return replace(self, steadiness=kept * self.steadiness + (1 - kept) * self.detected)

    def wait(self, dt: float) -> Self:
        """Let the time without a detection stand still: the detector did not look at this frame."""
        return replace(self, last_time=self.last_time + dt)

    def detect(self, box: Box, time: float, smoothing: float = 0.0) -> Self:
        """Put it where it is detected; it keeps a share of its old size, the smoothing.

        While something hides it more and more, it stays as large and as fast as it was.
        """
        found, old = ellipse_from_box(self.tracker, box), self.predicted
        a = smoothing * old.a + (1 - smoothing) * found.a
        b = smoothing * old.b + (1 - smoothing) * found.b
        ellipse = found._replace(a=a, b=b)
        state = replace(
            self._moved(self.state, old, ellipse),
            reference_size=ellipse,
            status=Status.TRACKING,
            frames_missed=0,
        )
        track = replace(self.track, ellipse=ellipse, status=Status.TRACKING)
        moved = self.moved or _far(ellipse._replace(x=self.origin[0], y=self.origin[1]), ellipse)
        lately = (each for each in self.recent if time - each.time <= WINDOW)
        recent = (*lately, Sighting(time, box, float(self.velocity[0])))
        # Beside others, a side may be theirs.
        hiding = None if self.met else hiding_of(recent, 2 * self.axes[0])
        velocity, axes, hidden_side = self.velocity, self.axes, self.hidden_side
        if hiding is not None and hiding.side != hidden_side:  # they stay while it is seen in part
            velocity, axes = np.array((hiding.speed, velocity[1])), (hiding.width / 2, axes[1])
            hidden_side = hiding.side
        small = found.a * found.b < CUT * math.prod(self.axes) and self.cut_for <= REMEMBERED
        part = small or hiding is not None
        return replace(
            self,
            state=state,
            track=track,
            velocity=velocity,
            last_time=time,
            detected=True,
            occluded_by=None,
            moved=moved,
            axes=axes if part else ellipse[2:4],
            cut_for=self.cut_for if part else 0.0,
            hidden_side=hidden_side if part else 0,
            recent=recent,
        )

    def vote(self, found: Detection) -> Self:
        """Note a detection's score, and count its class, if it has one."""
        best, label = max(self.best, found.score), found.label
        votes = self.votes if label is None else {**self.votes, label: self.votes.get(label, 0) + 1}
        return replace(self, best=best, votes=votes)

    def update_velocity(self, smoothing: float, dt: float) -> Self:
        """Correct its velocity by the detection; it keeps a share of the old one, the smoothing.

        The center of a part moves otherwise than the object.
        """
        if self.cut_for:
            return self
        now, then, (dx, dy) = self.track.ellipse, self.predicted, self.surprise
        x, y, size, follows = now.x - then.x, now.y - then.y, math.prod(self.axes), 1 - smoothing
        surprise = (
            smoothing * dx + follows * (x * x / size),
            smoothing * dy + follows * (y * y / size),
        )
        velocity = self.velocity + np.array((follows * x / dt, follows * y / dt))
        return replace(self, velocity=velocity, surprise=surprise)

    def variance(self, now: float, dt: float, smoothing: float) -> Floats:
        """Return the variance (2,) of where it is predicted, in squared mean half-axes.

        That of a forecast with a smoothed velocity, frames ahead: Hyndman et al., Forecasting with
        Exponential Smoothing, 2008, the additive trend with alpha 1.
        """
        frames, follows = max((now - self.last_time) / dt, 1.0), 1 - smoothing
        slope = 1 + follows * frames + follows**2 * frames * (2 * frames - 1) / 6
        return np.array(self.surprise) * (1 + (frames - 1) * slope)

    def observe(self, frame: Frame, dt: float, *, learn: bool) -> Self:
        """Run a step of its filter, around where it is detected or should be.

        The place of a detected object is that of its detection; the filter learns its appearance.
        """
        before = replace(self.state, time=frame.time - dt)
        state, info = self.tracker.step(self.rng, before, frame)
        if not learn:
            state = replace(state, models=before.models, memories=before.memories)
        track = info.track
        if self.detected:
            state = self._moved(state, track.ellipse, self.track.ellipse)
            track = replace(track, ellipse=self.track.ellipse, status=Status.TRACKING)
        return replace(self, before_observation=self.state, state=state, track=track)

    def occlude(self, occluder: int | None) -> Self:
        """Mark it as occluded by another object, or by scenery; and undo this frame's observation.

        What the filter observed was something else. The object is as large as it was as a whole,
        and the rest of it is on the side that was hidden.
        """
        x = self.predicted.x + self.hidden_side * (self.axes[0] - self.predicted.a)
        whole = self.predicted._replace(x=x, a=self.axes[0], b=self.axes[1])
        return replace(
            self,
            state=self._moved(self.before_observation, self.predicted, whole),
            predicted=whole,
            track=replace(self.track, status=Status.OCCLUDED),
            occluded_by=occluder,
        )

    def in_sight(self, frame: Frame, place: Ellipse) -> Self:
        """Put it where it is seen, though it is not detected; its velocity stays."""
        before = self.state if self.occluded else self.before_observation
        track = replace(
            self.track, frame=frame.index, time=frame.time, ellipse=place, status=Status.TRACKING
        )
        state = self._moved(before, self.predicted, place)
        return replace(self, state=state, track=track, predicted=place, occluded_by=None)

    def extrapolate(self, frame: Frame) -> Self:
        """Put it where it should be in a frame in which it is occluded."""
        track = replace(self.track, frame=frame.index, time=frame.time, ellipse=self.predicted)
        return replace(self, track=track)

    def terminate(self) -> Self:
        """Mark it as lost."""
        lost = replace(self.track, status=Status.LOST)
        return replace(self, track=lost, occluded_by=None)

    def with_identity_of(self, other: TrackedObject) -> Self:
        """Give it the identity and the models of another object; it stays where it is."""
        theirs = other.state
        return replace(
            self,
            identity=other.identity,
            rng=other.rng,
            best=other.best,
            votes=other.votes,
            known=other.known,
            met=other.met,
            state=replace(
                self.state,
                models=theirs.models,
                memories=theirs.memories,
                backgrounds=theirs.backgrounds,
            ),
        )

    def distances(self, frame: Frame, ellipses: Floats) -> Floats:
        """Return the distances of its models from the regions in ellipses (m, 5): (m,)."""
        cues = self.tracker.cues
        each = [
            cue.distances(self.state.models[name], frame, ellipses) for name, cue in cues.items()
        ]
        return fuse_distances(np.array(each), np.full(len(cues), 1 / len(cues)))

    def _moved(self, state: FilterState, old: Ellipse, new: Ellipse) -> FilterState:
        """Return a state with the particles moved and scaled as one ellipse to another, at rest."""
        motion, away = self.tracker.motion, (new.x - old.x, new.y - old.y, 0.0, 0.0, 0.0)
        ellipses = motion.ellipses(state.states)
        if new[2:4] != old[2:4]:
            ellipses = ellipses * np.array((1.0, 1.0, new.a / old.a, new.b / old.b, 1.0))
        ellipses = ellipses + np.array(away)  # faster than with a tuple
        return replace(state, states=motion.initial(ellipses))


def _far(first: Ellipse, second: Ellipse) -> bool:
    """Return whether an ellipse is farther from another than its mean half-axis."""
    away = math.hypot(second.x - first.x, second.y - first.y)
    return away > math.sqrt(second.a * second.b)


def ellipse_from_box(tracker: ParticleFilter, box: Box) -> Ellipse:
    """Return the ellipse in a box in the motion model's form, perhaps turned by 90 degrees."""
    motion = tracker.motion
    upright = np.array([Ellipse.from_box(box)])
    return Ellipse(*motion.ellipses(motion.initial(upright))[0].tolist())
