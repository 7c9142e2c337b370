"""Many objects before one fixed camera: who comes, who is who, who is hidden, who is gone.

Zhao and Pei, section 3: detections begin objects, a particle filter follows each, occlusion is
foreseen from where they are, the hidden one is the one that is less like itself, and is found again
by its model when it comes up.
"""

from __future__ import annotations

import contextlib
import math
from collections.abc import Generator, Iterable, Mapping, Sequence
from typing import NamedTuple

import numpy as np
from msgspec.structs import replace
from numpy.typing import NDArray

from motes.core.detection import Detection, Detector, best
from motes.core.errors import SourceError
from motes.core.frame import FRAME_INTERVAL, Frame
from motes.core.geometry import Box
from motes.core.seed import checked_seed
from motes.mot.assignment import assign_pairs
from motes.mot.association import (
    DetectionOutcome,
    LoggedDetection,
    as_rows,
    intersection_over_first,
    occlusion_candidates,
    split_merged_blob,
)
from motes.mot.identity_switch import is_identity_switch, shape_model
from motes.mot.overlaps import holding, largest, lying, nested, overlapping, singles
from motes.mot.pairs import Floats, Integers
from motes.mot.scene_config import SceneConfig, scene_config
from motes.mot.track_initiation import TrackInitiation
from motes.mot.tracked_object import SceneTrack, TrackedObject
from motes.video.prefetch import prefetch

COVERED_AGE_FACTOR = 2
"""One that is where another one is seen is waited for so many times as long: it cannot be seen."""


class _Found(NamedTuple):
    """What a detector said of a frame, and its warnings up to then."""

    detections: Sequence[Detection]
    warnings: Mapping[str, str]


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
    detection_log
        What became of every detection of the last frame.
    created, terminated
        How many objects there have been, and how many of them are gone.
    warnings
        What the detector has told about the pictures so far, each once (see `BackgroundDetector`);
        and as `limit`, that there were too many detections.
    """

    detection_log: list[LoggedDetection]
    warnings: Mapping[str, str]

    def __init__(
        self,
        detector: Detector,
        config: str | SceneConfig = "nummiaro:adaptive",
        seed: int = 0,
    ) -> None:
        self.config = scene_config(config) if isinstance(config, str) else config
        self._detector, self._seed = detector, checked_seed(seed)
        self._objects: list[TrackedObject] = []
        birth = (
            self.config.association.overlap,
            self.config.initiation.min_hits,
            self.config.initiation.min_score_quantile,
        )
        self._births = TrackInitiation(*birth)
        self._last: Frame | None = None
        self.detection_log = []
        self.created = self.terminated = 0
        self.warnings = {}
        self._own: dict[str, str] = {}

    def update(self, frame: Frame | NDArray[np.uint8]) -> list[SceneTrack]:
        """Return the objects in the next frame, also those that are hidden, oldest first.

        Raises
        ------
        SourceError
            If the frame's size has changed, or its time is not after the last one's.
        """
        picture, dt = self._next(frame)
        return self._step(picture, dt, self._detect(picture))

    def watch(
        self, frames: Iterable[Frame], *, ahead: bool = True
    ) -> Generator[tuple[Frame, list[SceneTrack]], None, None]:
        """Yield each frame and what `update` says of it.

        Parameters
        ----------
        frames
            In order.
        ahead
            Whether a thread finds what is in the next two frames meanwhile: what is said stays the
            same, and is said later where frames come live and faster than they can be followed.

        Raises
        ------
        SourceError
            As `update`. What `frames` and the detector raise comes after the frames before.
        """
        found = ((frame, self._detect(frame)) for frame in frames)
        with prefetch(found, 1) if ahead else contextlib.nullcontext(found) as detected:
            for frame, what in detected:
                yield frame, self._step(*self._next(frame), what)

    def _detect(self, frame: Frame) -> _Found:
        """Return what the detector says of a frame."""
        found = self._detector(frame)
        return _Found(found, dict(getattr(self._detector, "warnings", {})))

    def _step(self, picture: Frame, dt: float, found: _Found) -> list[SceneTrack]:
        """Follow all objects into the next frame."""
        self.detection_log = []
        free = self._suppress_duplicates(picture, found.detections)
        self.warnings = {**found.warnings, **self._own}
        for thing in self._objects:
            thing.predict(dt)
        free = self._associate(picture, dt, free)
        self._update(picture, dt)
        self._mark_occluded(picture)
        free = self._reidentify(picture, free)
        free = self._drop_fragments(free)
        self._initiate(picture, free)
        return self._report(picture)

    def _resolve_identity_switches(self, frame: Frame) -> None:
        """Let objects trade who they are if they are mistaken for each other, once they are apart.

        In that frame, the last one, both are detected, and neither hides a part of the other.
        """
        known = {thing.identity: thing for thing in self._objects}
        for thing in self._objects:
            other = known.get(thing.occluder_candidate or 0)
            if other is None:
                thing.occluder_candidate = None
            elif thing.detected and other.detected and not _touch(thing, other):
                thing.occluder_candidate = None
                if is_identity_switch(thing, other, frame):
                    thing.swap_identity(other)
                    known |= {thing.identity: thing, other.identity: other}

    def _next(self, frame: Frame | NDArray[np.uint8]) -> tuple[Frame, float]:
        """Leave the last frame; return a picture as the next one, and the seconds between them."""
        last = self._last
        if last is not None:
            self._resolve_identity_switches(last)
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

    def _suppress_duplicates(self, frame: Frame, found: Sequence[Detection]) -> list[Detection]:
        """Return the detections that can be objects, one for each."""
        useful: list[Detection] = []
        for each in sorted(found, key=lambda d: (-d.score, -d.box.width * d.box.height)):
            if not math.isfinite(each.score) or best([each], frame) is None:
                self.detection_log.append(LoggedDetection(each, DetectionOutcome.USELESS))
            else:
                useful.append(each)
        limit = self.config.detections.limit
        if len(useful) > limit:
            text = f"there are {len(useful)} detections; only the {limit} surest are taken"
            self._own.setdefault("limit", f"Frame {frame.index}: {text}.")
        self.detection_log += [
            LoggedDetection(each, DetectionOutcome.SURPLUS) for each in useful[limit:]
        ]
        useful = useful[:limit]
        overlap = self.config.detections.duplicate_overlap
        kept = singles(as_rows(each.box for each in useful), overlap)
        doubles = np.delete(np.arange(len(useful)), kept).tolist()
        self.detection_log += [LoggedDetection(useful[i], DetectionOutcome.DOUBLE) for i in doubles]
        sifted = [useful[i] for i in kept]
        self._births.note(sifted)
        return sifted

    def _associate(self, frame: Frame, dt: float, found: list[Detection]) -> list[Detection]:
        """Give detections to the objects that were just seen; return the rest."""
        things = [thing for thing in self._objects if not thing.hidden]
        if not things or not found:
            return found
        places = as_rows(thing.predicted.box for thing in things)
        boxes = as_rows(each.box for each in found)
        larger = self.config.association.merged_blob_ratio
        blobs = holding(places, boxes, self.config.containment, larger)
        taken, held = set(blobs), [i for mine in blobs.values() for i in mine]
        for j, mine in blobs.items():
            self.detection_log.append(LoggedDetection(found[j], DetectionOutcome.SEVERAL))
            if not mine:  # those in it lie better in another such detection
                continue
            shared = split_merged_blob(places[mine], found[j].box)
            for i, box in zip(mine, shared.tolist(), strict=True):
                self._see(things[i], Box(*box), frame, dt)
        rows, columns, overlaps = overlapping(places, boxes, self.config.association.overlap)
        free = ~(np.isin(rows, held) | np.isin(columns, list(blobs)))
        rows, columns, overlaps = rows[free], columns[free], overlaps[free]
        distances = _distances(things, frame, boxes, rows, columns)
        costs = self.config.association.costs(overlaps, distances)
        for i, j in assign_pairs(rows, columns, costs, (len(things), len(found))):
            self._see(things[i], found[j].box, frame, dt)
            self.detection_log.append(
                LoggedDetection(found[j], DetectionOutcome.MATCHED, things[i].identity)
            )
            taken.add(j)
        return [each for j, each in enumerate(found) if j not in taken]

    def _see(self, thing: TrackedObject, box: Box, frame: Frame, dt: float) -> None:
        """Put an object that was just seen where it is now, and learn how fast it is."""
        thing.detect(box, frame.time, self.config.smoothing.size)
        thing.update_velocity(self.config.smoothing.velocity, dt)

    def _update(self, frame: Frame, dt: float) -> None:
        """Look for the objects that were just seen, around where they are detected or should be.

        Where one may hide another, no model learns.
        """
        near = [thing for thing in self._objects if not thing.hidden]
        pairs = occlusion_candidates(as_rows(thing.predicted.box for thing in near))
        meeting = set(pairs[0].tolist())
        for i, thing in enumerate(near):
            met = i in meeting
            thing.observe(frame, dt, learn=not met)
            if met and not thing.near_other:
                thing.shape_model = shape_model(thing, frame)
            thing.near_other = met

    def _mark_occluded(self, frame: Frame) -> None:
        """Decide which of the objects without a detection are hidden, and let them coast.

        The one that is covered is hidden by the one that is detected, or more like itself; any is
        hidden by something that is no object where the appearance rule fails.
        """
        near = [thing for thing in self._objects if not thing.hidden]
        boxes = as_rows(thing.track.box for thing in near)
        rows, columns = occlusion_candidates(boxes)
        covered = (
            intersection_over_first(boxes[rows], boxes[columns]) > self.config.occlusion.overlap
        )
        covers = _grouped(rows[covered], columns[covered])
        for i, thing in enumerate(near):
            if thing.detected:
                continue
            thing.occluded_by = _hider(thing, [near[j] for j in covers.get(i, ())])
            alone = frame.time - thing.last_time > self.config.occlusion.max_time_without_detection
            if thing.occluded_by is not None or not thing.recognized or alone:
                thing.hide()
                thing.occluder_candidate = thing.occluded_by
        for thing in self._objects:
            if thing.hidden:
                thing.extrapolate(frame)

    def _covers(self) -> dict[int, list[TrackedObject]]:
        """Return, for hidden objects by identity, the objects where one should be."""
        hidden = [thing for thing in self._objects if thing.hidden]
        if not hidden:
            return {}
        places, boxes = (as_rows(t.track.box for t in those) for those in (hidden, self._objects))
        i, j, _ = lying(places, boxes, self.config.containment)
        return {
            hidden[i].identity: [self._objects[j] for j in others]
            for i, others in _grouped(i, j).items()
        }

    def _reidentify(self, frame: Frame, free: list[Detection]) -> list[Detection]:
        """Give detections to hidden objects that come up again; return the rest."""
        things = [thing for thing in self._objects if thing.hidden]
        if not things or not free:
            return free
        boxes = as_rows(each.box for each in free)
        where = {thing.identity: thing.predicted for thing in self._objects}
        # Who is hidden may also stop, or turn round, behind what hides it.
        places = np.array(
            [
                (thing.predicted, where.get(thing.occluded_by or 0, thing.predicted))
                for thing in things
            ]
        )
        hidden = np.array([frame.time - thing.last_time for thing in things])
        rows, columns, off = self.config.association.near(places, hidden, boxes)
        distances = _distances(things, frame, boxes, rows, columns)
        costs = self.config.association.recoveries(off, distances)
        pairs = zip(rows.tolist(), columns.tolist(), strict=True)
        looks = dict(zip(pairs, distances.tolist(), strict=True))
        taken = set()
        for i, j in assign_pairs(rows, columns, costs, (len(things), len(free))):
            thing, distance = things[i], looks[i, j]
            thing.detect(free[j].box, frame.time)
            sure = self.config.tracker.calibration.probability(distance)
            thing.track = replace(thing.track, distance=distance, confidence=sure)
            self.detection_log.append(
                LoggedDetection(free[j], DetectionOutcome.FOUND, thing.identity)
            )
            taken.add(j)
        return [each for j, each in enumerate(free) if j not in taken]

    def _drop_fragments(self, free: list[Detection]) -> list[Detection]:
        """Return the detections that are no part of an object that is seen anyway."""
        things = [thing for thing in self._objects if not thing.hidden]
        if not things or not free:
            return free
        boxes, seen = as_rows(each.box for each in free), as_rows(t.track.box for t in things)
        part = largest(*nested(boxes, seen, self.config.containment))
        self.detection_log += [
            LoggedDetection(free[i], DetectionOutcome.PART, things[j].identity)
            for i, j in part.items()
        ]
        return [each for i, each in enumerate(free) if i not in part]

    def _initiate(self, frame: Frame, free: list[Detection]) -> None:
        """Make objects of what was confirmed often enough, and candidates of the rest."""
        for each, sightings in zip(free, self._births.update(frame.time, free), strict=True):
            if sightings is None:
                self.detection_log.append(LoggedDetection(each, DetectionOutcome.DOUBTFUL))
            elif len(sightings) < self.config.initiation.min_hits:
                self.detection_log.append(LoggedDetection(each, DetectionOutcome.CANDIDATE))
            else:
                self.created += 1
                rng = np.random.Generator(np.random.PCG64((self._seed, self.created)))
                tracker = self.config.tracker
                self._objects.append(
                    TrackedObject.begin(self.created, tracker, rng, frame, sightings)
                )
                self.detection_log.append(
                    LoggedDetection(each, DetectionOutcome.BORN, self.created)
                )

    def _report(self, frame: Frame) -> list[SceneTrack]:
        """Return what there is to say about the objects, and forget those that are gone."""
        said, staying = [], []
        covers = self._covers()
        for thing in self._objects:
            unseen = frame.time - thing.last_time
            leaving = not _within(thing.track.box, frame)
            known = max(thing.last_time - thing.first_time, self.config.termination.min_max_age)
            patience = min(self.config.termination.max_age, known)
            covered = any(not other.hidden for other in covers.get(thing.identity, []))
            patience *= COVERED_AGE_FACTOR if covered else 1
            if unseen > (self.config.termination.max_age_at_border if leaving else patience):
                thing.terminate()
                self.terminated += 1
            else:
                staying.append(thing)
            said.append(thing.to_track)
        self._objects = staying
        return said


def _distances(
    things: Sequence[TrackedObject], frame: Frame, boxes: Floats, i: Integers, j: Integers
) -> Floats:
    """Return how far boxes (m, 4) are from the objects' models, for pairs (k,) sorted by object."""
    distances = np.empty(len(i))
    for one, which in _grouped(i, np.arange(len(i))).items():
        distances[which] = things[one].distances(frame, boxes[j[which]])
    return distances


def _grouped(i: Integers, j: Integers) -> dict[int, Integers]:
    """Return for each i all its j; i is sorted."""
    found, starts = np.unique(i, return_index=True)
    return dict(zip(found.tolist(), np.split(j, starts[1:]), strict=True)) if len(i) else {}


def _hider(thing: TrackedObject, near: Sequence[TrackedObject]) -> int | None:
    """Return the identity of the one that hides an object, of those that cover it, or None."""
    for other in near:
        if not other.hidden and (other.detected or other.track.distance < thing.track.distance):
            return other.identity
    return None


def _touch(one: TrackedObject, other: TrackedObject) -> bool:
    """Return whether the boxes of two objects overlap."""
    return bool(intersection_over_first(as_rows([one.track.box]), as_rows([other.track.box])).any())


def _within(box: Box, frame: Frame) -> bool:
    """Return whether a box lies inside the frame, not at its border."""
    return (
        box.x > 0
        and box.y > 0
        and box.x + box.width < frame.width
        and box.y + box.height < frame.height
    )
