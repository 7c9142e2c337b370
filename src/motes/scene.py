"""Many objects before one fixed camera: who comes, who is who, who is hidden, who is gone.

Zhao and Pei, section 3: detections begin objects, a particle filter follows each, occlusion is
foreseen from where they are, the hidden one is the one that is less like itself, and is found again
by its model when it comes up.
"""

from __future__ import annotations

import itertools
import math
from collections import deque
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from enum import StrEnum
from typing import Annotated

import numpy as np
from msgspec import Meta
from msgspec.structs import replace
from numpy.typing import NDArray

from motes.association import Association, assign, inside, meet
from motes.config import Config, Count, NonNegative, Positive, Share
from motes.detection import Detection, Detector, best
from motes.errors import ConfigError, SourceError
from motes.frame import FRAME_INTERVAL, Frame
from motes.geometry import Box, Ellipse, iou
from motes.particle_filter import FilterState, ParticleFilter, combined
from motes.presets import PRESETS, preset
from motes.track import Status, Track

Floats = NDArray[np.float64]


class Outcome(StrEnum):
    """What became of a detection."""

    MATCHED = "matched"
    """It is where an object is that was just seen."""
    FOUND = "found"
    """It is where an object comes up again that was hidden."""
    BORN = "born"
    """It makes an object of a candidate."""
    CANDIDATE = "candidate"
    """It may be an object; the next frames will tell."""
    SEVERAL = "several objects"
    """Two or more objects lie in it, as in a blob where they touch."""
    PART = "part of an object"
    """It lies on an object that has a better detection, or that is being followed without."""
    DOUBLE = "the same as a surer one"
    """It lies on a detection that scores higher, or is larger."""
    DOUBTFUL = "doubtful"
    """It is among the least sure detections so far, which begin no objects."""
    USELESS = "too small, too large or outside"
    """No tracker can start on it."""


@dataclass(frozen=True, slots=True)
class Account:
    """A detection, what became of it, and which object it went to."""

    detection: Detection
    outcome: Outcome
    identity: int | None = None


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
    behind
        The identity of what hides it, if that is an object.
    detected
        Whether a detection confirms it in this frame.
    """

    identity: int
    track: Track
    behind: int | None = None
    detected: bool = False


class SceneConfig(Config, frozen=True):
    """How objects come, stay and go.

    Attributes
    ----------
    tracker
        What follows each object.
    association
        What makes a detection the same object as before.
    double
        A detection with more than this share in a surer one, or the other way round, is the same.
    doubt
        This share of all detections, the least sure ones, begins no objects.
    confirm
        A detection becomes an object when it is confirmed in so many frames in a row.
    inertia
        Share of its velocity that an object keeps when a detection says another one.
    covered
        An object is hidden by another if that covers more than this share of it.
    alone
        Seconds for which colors alone may follow an object that no detection confirms.
    patience
        Seconds for which a hidden object is waited for, if it was known for as long before.
    farewell
        The same where it should be at the border, or outside.
    """

    tracker: ParticleFilter
    association: Association = Association()
    double: Share = 0.6
    doubt: Share = 0.25
    confirm: Count = 3
    inertia: Share = 0.8
    covered: Annotated[float, Meta(gt=0, le=1)] = 0.3
    alone: NonNegative = 0.12
    patience: Positive = 2.0
    farewell: NonNegative = 0.2


WITHIN = 0.7
"""A box with more than this share of it in another one lies within that."""
LARGER = 1.4
"""A detection with two objects in it is that much larger than either."""
LEAST_PATIENCE = 0.4
"""Seconds for which any hidden object is waited for."""
SCORES = 1000
"""How sure detections are is judged by so many of the latest."""
PLACES = 2000
"""An object's background is looked at around so many places at its birth: a few milliseconds."""


def scene_config(tracker: str | ParticleFilter = "nummiaro:adaptive") -> SceneConfig:
    """Return the configuration of a scene whose objects a preset follows.

    Raises
    ------
    ConfigError
        If the preset is unknown or no particle filter.
    """
    config = preset(tracker) if isinstance(tracker, str) else tracker
    if not isinstance(config, ParticleFilter):
        filters = [name for name, known in PRESETS.items() if isinstance(known, ParticleFilter)]
        raise ConfigError(f"Objects are followed by particle filters: {', '.join(filters)}.")
    presence = replace(config.presence, places=min(config.presence.places, PLACES))
    return SceneConfig(tracker=replace(config, presence=presence))


@dataclass(slots=True, eq=False)
class _Object:
    """What is known of an object.

    `velocity` is in pixels a second, `since` and `seen` are the times of its first and its last
    detection. `place` is where it
    should be in this frame, `foreseen` its filter's state before it looked at the frame.
    """

    identity: int
    rng: np.random.Generator
    state: FilterState
    track: Track
    velocity: Floats
    since: float
    seen: float
    detected: bool = True
    behind: int | None = None
    foreseen: FilterState = field(init=False)
    place: Ellipse = field(init=False)

    @property
    def hidden(self) -> bool:
        return self.track.status is Status.OCCLUDED


class Scene:
    """Gives every object before a fixed camera an identity, from entry to exit.

    Parameters
    ----------
    detector
        What finds objects: any callable from a `Frame` to `Detection`s.
    config
        A preset's name, or a configuration.
    seed
        Of the random numbers; each object has its own, whatever the others do.

    Attributes
    ----------
    accounts
        What became of every detection of the last frame.
    born, gone
        How many objects there have been, and how many of them are gone.
    """

    accounts: list[Account]

    def __init__(
        self,
        detector: Detector,
        config: str | SceneConfig = "nummiaro:adaptive",
        seed: int = 0,
    ) -> None:
        self.config = scene_config(config) if isinstance(config, str) else config
        if not isinstance(seed, int | np.integer) or seed < 0:
            raise ConfigError(f"A seed is a whole number from 0 up; got {seed!r}.")
        self._detector, self._seed = detector, int(seed)
        self._objects: list[_Object] = []
        self._candidates: list[list[tuple[float, Box]]] = []
        self._scores: deque[float] = deque(maxlen=SCORES)
        self._last: Frame | None = None
        self.accounts = []
        self.born = self.gone = 0

    @property
    def remarks(self) -> Mapping[str, str]:
        """What the detector has to tell about the picture, each once; see `BackgroundDetector`."""
        return getattr(self._detector, "remarks", {})

    def update(self, frame: Frame | NDArray[np.uint8]) -> list[SceneTrack]:
        """Return the objects in the next frame, also those that are hidden, oldest first.

        Raises
        ------
        SourceError
            If the frame's size has changed, or its time is not after the last one's.
        """
        picture, dt = self._next(frame)
        self.accounts = []
        free = self._sift(picture, self._detector(picture))
        for thing in self._objects:
            self._foresee(thing, picture, dt)
        free = self._match(picture, dt, free)
        self._follow(picture, dt)
        self._hide(picture)
        free = self._recover(picture, free)
        free = self._spare(free)
        self._bear(picture, free)
        return self._say(picture)

    def _next(self, frame: Frame | NDArray[np.uint8]) -> tuple[Frame, float]:
        """Return a picture as the next frame, and the seconds since the last one."""
        last = self._last
        if not isinstance(frame, Frame):
            frame = (
                Frame(0, 0.0, frame)
                if last is None
                else Frame(last.index + 1, last.time + FRAME_INTERVAL, frame)
            )
        if last is not None and frame.pixels.shape != last.pixels.shape:
            raise SourceError(
                f"Frame {frame.index} is {frame.width}x{frame.height}, the ones before were "
                f"{last.width}x{last.height}; a scene needs a camera that stays the same."
            )
        if last is not None and not frame.time > last.time:
            raise SourceError(
                f"Frame {frame.index} at {frame.time:g} s does not come after {last.time:g} s; "
                f"give frames in order."
            )
        self._last = frame
        return frame, FRAME_INTERVAL if last is None else frame.time - last.time

    def _sift(self, frame: Frame, found: Sequence[Detection]) -> list[Detection]:
        """Return the detections that can be objects, one for each."""
        kept: list[Detection] = []
        for each in sorted(found, key=lambda d: (-d.score, -d.box.width * d.box.height)):
            if not math.isfinite(each.score) or best([each], frame) is None:
                self.accounts.append(Account(each, Outcome.USELESS))
                continue
            one, others = _boxes([each.box]), _boxes(other.box for other in kept)
            shared = np.maximum(inside(one, others)[0], inside(others, one)[:, 0])
            if (shared > self.config.double).any():
                self.accounts.append(Account(each, Outcome.DOUBLE))
            else:
                kept.append(each)
        self._scores.extend(each.score for each in kept)
        return kept

    def _foresee(self, thing: _Object, frame: Frame, dt: float) -> None:
        """Say where an object should be by now, and move its particles there."""
        old, (dx, dy) = thing.track.ellipse, (thing.velocity * dt).tolist()
        thing.place = old._replace(x=old.x + dx, y=old.y + dy)
        thing.state = self._moved(thing.state, old, thing.place)
        thing.detected = False

    def _moved(self, state: FilterState, old: Ellipse, new: Ellipse) -> FilterState:
        """Return a filter's state with its particles moved and resized, at rest, as a whole."""
        motion = self.config.tracker.motion
        ellipses = motion.ellipses(state.states).copy()
        ellipses[:, :2] += np.array(new[:2]) - old[:2]
        ellipses[:, 2:4] *= np.array(new[2:4]) / old[2:4]
        return replace(state, states=motion.initial(ellipses))

    def _distances(self, things: Sequence[_Object], frame: Frame, boxes: Floats) -> Floats:
        """Return how far boxes (m, 4) are from the objects' models: (n, m)."""
        ellipses = np.array([Ellipse.from_box(box) for box in boxes.tolist()])
        cues = self.config.tracker.cues
        shares = np.full(len(cues), 1 / len(cues))
        out = np.empty((len(things), len(boxes)))
        for row, thing in zip(out, things, strict=True):
            models = thing.state.models
            each = [cue.distances(models[name], frame, ellipses) for name, cue in cues.items()]
            row[:] = combined(np.array(each), shares)
        return out

    def _match(self, frame: Frame, dt: float, found: list[Detection]) -> list[Detection]:
        """Give detections to the objects that were just seen; return the rest."""
        things = [thing for thing in self._objects if not thing.hidden]
        if not things or not found:
            return found
        places = _boxes(thing.place.box for thing in things)
        boxes = _boxes(each.box for each in found)
        # A detection in which two objects lie, and which is larger than either, is not one of them.
        within = inside(places, boxes) > WITHIN
        areas = np.where(within, places[:, 2:].prod(axis=1)[:, None], 0).max(axis=0)
        several = (within.sum(axis=0) > 1) & (boxes[:, 2:].prod(axis=1) > LARGER * areas)
        overlaps = np.where(several, 0, iou(places[:, None], boxes))
        costs = self.config.association.costs(overlaps, self._distances(things, frame, boxes))
        taken = set(np.flatnonzero(several).tolist())
        for j in taken:
            self.accounts.append(Account(found[j], Outcome.SEVERAL))
            for thing in itertools.compress(things, within[:, j]):
                thing.seen = frame.time
        for i, j in assign(costs):
            thing = things[i]
            self._place(thing, found[j].box, frame)
            off = np.array(thing.track.ellipse[:2]) - thing.place[:2]
            thing.velocity = thing.velocity + (1 - self.config.inertia) * off / dt
            self.accounts.append(Account(found[j], Outcome.MATCHED, thing.identity))
            taken.add(j)
        return [each for j, each in enumerate(found) if j not in taken]

    def _ellipse(self, box: Box) -> Ellipse:
        """Return the ellipse in a box as the motion model has it, perhaps turned by 90 degrees."""
        motion = self.config.tracker.motion
        upright = np.array([Ellipse.from_box(box)])
        return Ellipse(*motion.ellipses(motion.initial(upright))[0].tolist())

    def _place(self, thing: _Object, box: Box, frame: Frame) -> None:
        """Put an object where it is detected."""
        ellipse = self._ellipse(box)
        moved = self._moved(thing.state, thing.place, ellipse)
        thing.state = replace(moved, first=ellipse, status=Status.TRACKING, missed=0)
        thing.track = replace(thing.track, ellipse=ellipse, status=Status.TRACKING)
        thing.seen, thing.detected, thing.behind = frame.time, True, None

    def _follow(self, frame: Frame, dt: float) -> None:
        """Look for the objects that were just seen, around where they are detected or should be.

        Where one may hide another, no model learns.
        """
        near = [thing for thing in self._objects if not thing.hidden]
        for thing in near:
            thing.foreseen = thing.state
            before = replace(thing.state, time=frame.time - dt)
            thing.state, info = self.config.tracker.step(thing.rng, before, frame)
            if any(o is not thing and meet(thing.place.box, o.place.box) for o in near):
                thing.state = replace(thing.state, models=before.models, memories=before.memories)
            found = thing.track.ellipse if thing.detected else info.track.ellipse
            thing.track = replace(info.track, ellipse=found)
            if thing.detected:
                thing.state = self._moved(thing.state, info.track.ellipse, found)
                thing.track = replace(thing.track, status=Status.TRACKING)

    def _hide(self, frame: Frame) -> None:
        """Decide which of the objects without a detection are hidden, and let them coast.

        The one that is covered is hidden by the one that is detected, or more like itself; any is
        hidden by something that is no object where the appearance rule fails.
        """
        near = [thing for thing in self._objects if not thing.hidden]
        for thing in near:
            if thing.detected:
                continue
            thing.behind = self._hider(thing, near)
            there = thing.state.missed == 0 and thing.track.status is Status.TRACKING
            alone = frame.time - thing.seen
            if thing.behind is not None or not there or alone > self.config.alone:
                thing.state = thing.foreseen
                thing.track = replace(
                    thing.track, status=Status.OCCLUDED, ellipse=thing.place, confidence=0.0
                )
        for thing in self._objects:
            if thing.hidden:
                thing.track = replace(
                    thing.track, frame=frame.index, time=frame.time, ellipse=thing.place
                )

    def _hider(self, thing: _Object, near: Sequence[_Object]) -> int | None:
        """Return the identity of the object that hides one, or None."""
        box = thing.track.box
        for other in near:
            if other is thing or other.hidden or not meet(box, other.track.box):
                continue
            cover = inside(_boxes([box]), _boxes([other.track.box]))[0, 0]
            closer = other.detected or other.track.distance < thing.track.distance
            if cover > self.config.covered and closer:
                return other.identity
        return None

    def _recover(self, frame: Frame, free: list[Detection]) -> list[Detection]:
        """Give detections to hidden objects that come up again; return the rest."""
        things = [thing for thing in self._objects if thing.hidden]
        if not things or not free:
            return free
        boxes = _boxes(each.box for each in free)
        centers = boxes[:, :2] + (boxes[:, 2:] - 1) / 2
        where = {thing.identity: thing.place for thing in self._objects}
        away = np.empty((len(things), len(free)))
        for row, thing in zip(away, things, strict=True):
            size = math.sqrt(thing.place.a * thing.place.b)
            # Who is hidden may also stop, or turn round, behind what hides it.
            places = [thing.place, where.get(thing.behind or 0, thing.place)]
            row[:] = _nearest(centers, places) / size
        hidden = np.array([frame.time - thing.seen for thing in things])
        distances = self._distances(things, frame, boxes)
        taken = set()
        for i, j in assign(self.config.association.recoveries(away, hidden, distances)):
            thing, distance = things[i], float(distances[i, j])
            self._place(thing, free[j].box, frame)
            sure = self.config.tracker.calibration.probability(distance)
            thing.track = replace(thing.track, distance=distance, confidence=sure)
            self.accounts.append(Account(free[j], Outcome.FOUND, thing.identity))
            taken.add(j)
        return [each for j, each in enumerate(free) if j not in taken]

    def _spare(self, free: list[Detection]) -> list[Detection]:
        """Return the detections that are no part of an object that is seen anyway."""
        things = [thing for thing in self._objects if not thing.hidden]
        if not things or not free:
            return free
        boxes, seen = _boxes(each.box for each in free), _boxes(t.track.box for t in things)
        shared = np.maximum(inside(boxes, seen), inside(seen, boxes).T)
        rest = []
        for each, row in zip(free, shared, strict=True):
            if row.max() > WITHIN:
                self.accounts.append(
                    Account(each, Outcome.PART, things[int(row.argmax())].identity)
                )
            else:
                rest.append(each)
        return rest

    def _bear(self, frame: Frame, free: list[Detection]) -> None:
        """Make objects of what was confirmed often enough, and candidates of the rest."""
        before, self._candidates = self._candidates, []
        boxes = _boxes(each.box for each in free)
        latest = _boxes(candidate[-1][1] for candidate in before)
        overlaps = iou(latest[:, None], boxes) if before and free else np.zeros((0, 0))
        near = overlaps >= self.config.association.overlap
        history = {j: before[i] for i, j in assign(np.where(near, 1 - overlaps, np.inf))}
        sure = np.quantile(self._scores, self.config.doubt) if free else 0.0
        for j, each in enumerate(free):
            if each.score < sure:
                self.accounts.append(Account(each, Outcome.DOUBTFUL))
                continue
            candidate = [*history.get(j, []), (frame.time, each.box)]
            if len(candidate) < self.config.confirm:
                self._candidates.append(candidate)
                self.accounts.append(Account(each, Outcome.CANDIDATE))
            else:
                identity = self._begin(frame, candidate)
                self.accounts.append(Account(each, Outcome.BORN, identity))

    def _begin(self, frame: Frame, candidate: list[tuple[float, Box]]) -> int:
        """Start following an object; return its identity."""
        self.born += 1
        (began, first), (now, last) = candidate[0], candidate[-1]
        rng = np.random.Generator(np.random.PCG64((self._seed, self.born)))
        start, end = self._ellipse(first), self._ellipse(last)
        state, info = self.config.tracker.init(rng, frame, end)
        velocity = np.zeros(2)
        if now > began:
            velocity = (np.array(end[:2]) - start[:2]) / (now - began)
        track = replace(info.track, ellipse=end)
        self._objects.append(_Object(self.born, rng, state, track, velocity, began, now))
        return self.born

    def _say(self, frame: Frame) -> list[SceneTrack]:
        """Return what there is to say about the objects, and forget those that are gone."""
        said, staying = [], []
        for thing in self._objects:
            unseen = frame.time - thing.seen
            leaving = not _within(thing.track.box, frame)
            patience = min(self.config.patience, max(thing.seen - thing.since, LEAST_PATIENCE))
            if unseen > (self.config.farewell if leaving else patience):
                thing.track = replace(thing.track, status=Status.LOST, confidence=0.0)
                self.gone += 1
            else:
                staying.append(thing)
            said.append(SceneTrack(thing.identity, thing.track, thing.behind, thing.detected))
        self._objects = staying
        return said


def _boxes(boxes: Iterable[Box]) -> Floats:
    """Return boxes as (n, 4)."""
    return np.array(list(boxes), np.float64).reshape(-1, 4)


def _nearest(centers: Floats, places: Sequence[Ellipse]) -> Floats:
    """Return how far points (m, 2) are from the nearest of some places: (m,)."""
    each = [np.hypot(centers[:, 0] - place.x, centers[:, 1] - place.y) for place in places]
    nearest: Floats = np.min(each, axis=0)
    return nearest


def _within(box: Box, frame: Frame) -> bool:
    """Return whether a box lies inside the frame, not at its border."""
    return (
        box.x > 0
        and box.y > 0
        and box.x + box.width < frame.width
        and box.y + box.height < frame.height
    )
