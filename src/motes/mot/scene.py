"""Many objects before one camera, each with an identity from entry to exit.

`step` is the whole algorithm of Zhao and Pei, section 3: detections begin objects, and a particle
filter follows each. Occlusions are predicted from the objects' places. Of two objects, the one that
is less similar to its model is occluded. Its model finds it again when it reappears.
"""

from __future__ import annotations

import contextlib
import math
from collections.abc import Generator, Iterable, Iterator, Mapping, Sequence
from typing import Any, NamedTuple

import msgspec
import numpy as np
from msgspec.structs import replace
from numpy.typing import NDArray

from motes.core.config import checked_seed
from motes.core.detection import (
    Detection,
    Detector,
    ObservingDetector,
    PreparedDetector,
    as_detections,
    check_callable,
    class_names,
    usable,
)
from motes.core.errors import ConfigError, SourceError
from motes.core.frame import FRAME_INTERVAL, Frame, as_frame
from motes.core.geometry import FARTHEST, Box, as_samples, of_corners
from motes.core.log import LOG
from motes.core.track import Status, Track
from motes.core.types import Floats
from motes.mot.detection.moving_camera import (
    STILL,
    MovingCamera,
    PannedDetector,
    before_camera,
    corner_shifts,
)
from motes.mot.expected import Expected
from motes.mot.look import Look
from motes.mot.scene_config import SceneConfig, scene_config
from motes.mot.stages.admit import admit
from motes.mot.stages.associate import associate
from motes.mot.stages.follow_camera import follow_camera
from motes.mot.stages.initiate import initiate
from motes.mot.stages.mark_occluded import mark_occluded
from motes.mot.stages.reidentify import reidentify
from motes.mot.stages.report import report
from motes.mot.stages.suppress_duplicates import suppress_duplicates
from motes.mot.stages.tell_apart import tell_apart
from motes.mot.stages.update import update
from motes.mot.track_initiation import TrackInitiation
from motes.mot.tracked_object import TrackedObject
from motes.video.cuts import Change, PictureChanges, before_cut
from motes.video.prefetch import prefetch

DOUBTS = {
    "cut": "the film is cut to another picture",
    "light": "the light changes, or the camera moves",
    "camera": "the camera moves",
}
"""What makes counts doubtful, in words."""
LAG = 3
"""Frames after which a detector learns where objects will be: it may run two frames ahead."""
MANY = 10
"""Frames with detections after which most of their boxes tell that they are corners."""
OTHER_SCALE = 10
"""A score above this is on another scale than a `least` below 1, as one in percent is. Logits stay
below it."""


class SceneState(msgspec.Struct, frozen=True, eq=False):
    """What the next frame needs of those before."""

    objects: Sequence[TrackedObject] = ()
    """The objects that have not ended, oldest first."""
    initiation: TrackInitiation = TrackInitiation()
    """What may become an object."""
    created: int = 0
    """How many objects there have been."""
    frames: int = 0
    """How many frames there have been."""


class SceneInfo(NamedTuple):
    """What happened in a frame."""

    tracks: list[Track]
    """All tracks, oldest first."""
    surplus: int
    """How many detections were beyond the limit, and were not used."""
    admitted: Mapping[int, int]
    """The keys of the expected objects that began, by their identities."""


def step(
    seed: int,
    state: SceneState,
    frame: Frame,
    dt: float,
    detections: Sequence[Detection] | None,
    config: SceneConfig,
    expected: Sequence[Expected] = (),
    motion: Floats | None = None,
) -> tuple[SceneState, SceneInfo]:
    """Follow all objects into a frame, `dt` seconds after the last one. Zhao and Pei, section 3.

    Each object draws from random numbers of its own, which `seed` and its identity determine. If
    the detector did not look at the frame, detections are None, and tentative tracks wait.
    `motion` is that of the camera, a homography (3, 3) from the frame in which it was looked at
    last, if it moves.
    """
    looked = detections is not None
    if motion is not None:
        carried, initiation = follow_camera(state.objects, state.initiation, motion)
        state = replace(state, objects=carried, initiation=initiation)
    found, surplus = suppress_duplicates(detections or (), frame, config.detections)
    objects = [each.predict(dt) for each in state.objects]
    if not looked:
        objects = [
            each if each.occluded or each.found_by_look else each.wait(dt) for each in objects
        ]
    objects, free, covers = associate(objects, found, frame, dt, config)
    objects = update(objects, frame, dt)
    objects = mark_occluded(objects, frame, config.occlusion, looked=looked)
    objects, free = reidentify(objects, free, covers, frame, dt, config)
    initiation = state.initiation.with_scores(found, free)
    arrived, keys, free = admit(seed, state.created, expected, objects, free, frame, config)
    objects, created = objects + arrived, state.created + len(arrived)
    if looked:
        begun, initiation = initiate(seed, created, initiation, objects, free, frame, config)
        objects, created = objects + begun, created + len(begun)
        objects = [each.tallied(dt) for each in objects]
    tracks, staying = report(objects, frame, initiation.least, config)
    staying = tell_apart(staying, free, frame, state.frames, config.occlusion.overlap)
    after = SceneState(staying, initiation, created, state.frames + 1)
    return after, SceneInfo(tracks, surplus, keys)


class _Found(NamedTuple):
    """What a detector returns of a frame.

    Its detections, None if it did not look; its warnings up to then; the camera's motion; and how
    the picture has changed.
    """

    detections: Sequence[Detection] | None
    warnings: Mapping[str, str]
    motion: Floats | None
    change: Change | None


class Scene:
    """Gives every object before a camera an identity, from entry to exit.

    Parameters
    ----------
    detector
        What finds objects: any callable from a `Frame` to `Detection`s.
    config
        A preset's name, or a configuration.
    seed
        Seed of the random numbers. Each object has random numbers of its own.

    Raises
    ------
    ConfigError
        If the detector cannot be called, or the preset is unknown or no particle filter.
    MissingDependencyError
        If the camera is said to move and OpenCV is not installed.

    Attributes
    ----------
    detector
        The detector, which gives the camera's motion too (`before_camera`).
    """

    admitted: Mapping[int, int]
    """The keys of the expected objects that began in the last frame, by their identities; see
    `expect`."""
    warnings: Mapping[str, str]
    """The detector's warnings so far, each once (see `BackgroundDetector`); as `limit`, that there
    were too many detections; as `broken`, that some are no boxes; as `corners`, that most seem to
    be left, top, right, bottom; as `scale`, that scores are not on the scale of `least`."""
    doubts: dict[str, int]
    """The first frame from which on each of `DOUBTS` makes counts doubtful."""

    def __init__(
        self,
        detector: Detector,
        config: str | SceneConfig = "nummiaro:adaptive",
        seed: int = 0,
    ) -> None:
        self.config = scene_config(config) if isinstance(config, str) else config
        if not isinstance(self.config, SceneConfig):
            raise ConfigError(
                f"A scene takes a preset's name or a motes.scene_config(); got {config!r}."
            )
        check_callable(detector)
        self.detector = before_camera(detector, self.config.camera)
        self._seed = checked_seed(seed)
        self._state = SceneState()
        self._last: Frame | None = None
        self._detected = 0
        self._moved: dict[int, list[Box]] = {}
        self.admitted, self.warnings, self.doubts = {}, {}, {}
        self._changes = PictureChanges()
        self._expected: Sequence[Expected] = ()
        self._own_warnings: dict[str, str] = {}
        self._previewed = list[int]()
        self._looked = self._boxes = self._corners = 0
        self._statuses: dict[int, Status] = {}
        self._labels, self._surest, self._usable = set[str](), -math.inf, False

    @property
    def created(self) -> int:
        """How many objects there have been."""
        return self._state.created

    @property
    def terminated(self) -> int:
        """How many objects have ended."""
        return self.created - len(self._state.objects)

    @property
    def left_out(self) -> str | None:
        """Why no detection before the first object had a class, a score and a box that are used.

        None if one had, or there was none.
        """
        rule = self.config.detections
        if self._labels and rule.classes and not self._labels.intersection(rule.classes):
            seen, wanted = ", ".join(sorted(self._labels))[:200], ", ".join(rule.classes)
            return f"the detector found objects of class {seen}, none of class {wanted}"
        if self._labels and rule.least is not None and self._surest < rule.least:
            return f"all scores are below {rule.least:g}; the highest is {self._surest:g}"
        if self._labels and not self._usable:
            return (
                "no detection has its center in the picture and a size of two pixels or more, "
                "up to the whole picture"
            )
        return None

    @property
    def unseen_classes(self) -> str | None:
        """Which classes that are asked for no detection had, of a detector that names none."""
        wanted = self.config.detections.classes
        missing = [name for name in wanted if name not in self._labels]
        if not missing or class_names(self.detector):
            return None
        seen = ", ".join(sorted(self._labels))[:200] or "nothing"
        return f"no detection was of class {', '.join(missing)}; the detector found {seen}"

    @property
    def looks(self) -> dict[int, Look]:
        """How each object looked when it was last clear of others, if it ever was, by identity."""
        return {each.identity: each.look for each in self._state.objects if each.look is not None}

    def prepare(self, frames: Iterable[Frame | NDArray[Any]]) -> None:
        """Let the detector see the begin of a film, before the first frame of the same film.

        A `BackgroundDetector` learns what the background is: else it begins with the first frame,
        and an object that stands there leaves a ghost for a time. Behind a cut of the film it is
        another one. Other detectors read no frame. `frames` are those of `watch`.
        """
        if isinstance(self.detector, PreparedDetector):
            self.detector.prepare(self._noted(before_cut(_in_order(frames, None))))

    def _noted(self, frames: Iterable[Frame]) -> Iterator[Frame]:
        """Yield the frames that the detector takes before the first one, and note their indices."""
        for frame in frames:
            self._previewed.append(frame.index)
            yield frame

    def expect(self, expected: Sequence[Expected]) -> None:
        """Expect objects in the next frame; they begin as soon as they are seen there.

        Raises
        ------
        ConfigError
            If the samples or the velocity of one cannot be used.
        """
        self._expected = [_checked(each) for each in expected]

    def update(self, frame: Frame | NDArray[Any]) -> list[Track]:
        """Return the objects in the next frame, also those that are occluded, oldest first.

        Raises
        ------
        SourceError
            If the frame's size has changed, or its time is not after the last one's.
        ConfigError
            If the detector's detections or its motion are in no form that is known.
        """
        picture = as_frame(frame, self._last)
        self._check(picture)
        return self._step(picture, self._detect(picture))

    def watch(
        self, frames: Iterable[Frame | NDArray[Any]], *, ahead: bool = True
    ) -> Generator[tuple[Frame, list[Track]], None, None]:
        """Yield each frame and its objects, as `update` returns them.

        Parameters
        ----------
        frames
            In order: `Frame`s or images, as for `update`.
        ahead
            Whether a thread runs the detector on the next frames meanwhile: two, or as many more as
            it leaves out. The results are the same. They come later if frames are live and faster
            than they can be followed.

        Raises
        ------
        SourceError
            As `update`. Errors of `frames` and of the detector come after the frames before.
        """
        found = ((frame, self._detect(frame)) for frame in _in_order(frames, self._last))
        queue = self.config.detections.every
        with prefetch(found, queue) if ahead else contextlib.nullcontext(found) as detected:
            for frame, what in detected:
                self._check(frame)
                yield frame, self._step(frame, what)

    def _detect(self, frame: Frame) -> _Found:
        """Return what the detector finds in a frame, if it is its turn."""
        every = self.config.detections.every
        turn = self._detected % every == 0
        moved = self._moved.pop(self._detected - LAG - (every - 1), [])
        self._detected += 1
        if turn and isinstance(self.detector, ObservingDetector):
            self.detector.observe(moved)
        camera = self.detector if isinstance(self.detector, MovingCamera | PannedDetector) else None
        found = as_detections(self.detector(frame)) if turn else None
        if camera is not None and not turn:
            camera.glance(frame)
        known = turn or camera is not None
        motion = _homography(getattr(self.detector, "motion", None)) if known else None
        warnings = dict(getattr(self.detector, "warnings", {}))
        return _Found(found, warnings, motion, self._changes.update(frame))

    def _step(self, frame: Frame, found: _Found) -> list[Track]:
        """Follow all objects into the next frame."""
        dt = FRAME_INTERVAL if self._last is None else frame.time - self._last.time
        self._last = frame
        for each in found.detections or ():
            self._labels.add(each.label or "unknown")
            if self.created:
                continue
            self._surest = max(self._surest, each.score)
            self._usable = self._usable or usable(each, frame)
        ended = self._cut(frame) if found.change == "cut" else []
        self._state, info = step(
            self._seed, self._state, frame, dt, found.detections, self.config, self._expected,
            found.motion,
        )  # fmt: skip
        if isinstance(self.detector, ObservingDetector):
            ahead = dt * (LAG + self.config.detections.every - 1)
            moved = [each.box_after(ahead) for each in self._state.objects if each.moved]
            self._moved[self._state.frames - 1] = moved
        self._expected = ()
        self.admitted = info.admitted
        self._warn(frame, info.surplus, found.detections or ())
        self._doubt(frame, found)
        warnings = {**found.warnings, **self._own_warnings}
        for kind in warnings.keys() - self.warnings.keys():
            LOG.warning("%s", warnings[kind])
        self.warnings = warnings
        tracks = ended + info.tracks
        for found_object in tracks:
            identity, status = found_object.identity, found_object.status
            if status is not self._statuses.get(identity):
                LOG.info("Frame %d: object %d is %s.", frame.index, identity, status)
        self._statuses = {each.identity: each.status for each in info.tracks}
        return tracks

    def _cut(self, frame: Frame) -> list[Track]:
        """End all objects where the film is cut, as nothing goes on there; return their tracks."""
        gone = [each.terminate().extrapolate(frame).public_track for each in self._state.objects]
        self._state = SceneState(created=self.created, frames=self._state.frames)
        return gone

    def _doubt(self, frame: Frame, found: _Found) -> None:
        """Note from which frame on counts are doubtful; a cut looks like another light, too.

        What was prepared for holds what is before and behind a change in it, so all is doubtful.
        """
        kinds = [kind for kind in DOUBTS if kind in found.warnings and kind not in self.warnings]
        if found.motion is not None and self.config.camera != "moving":
            # Before one that stands still, what is not exact in a homography moves few corners.
            kinds += ["camera"] * bool(corner_shifts(found.motion, frame).min() > STILL)
        for kind in kinds if found.change is None else [found.change]:
            first = self._previewed[0] if frame.index in self._previewed else frame.index
            self.doubts.setdefault(kind, first)

    def _warn(self, frame: Frame, surplus: int, found: Sequence[Detection]) -> None:
        """Note what is wrong with the detections of a frame, each kind once."""
        said, rule = dict[str, str](), self.config.detections
        if broken := sum(map(_broken, found)):
            said["broken"] = f"detections with NaN, infinity or no size are left out, {broken} here"
        if surplus:
            taken = f"only the {rule.limit} surest are taken"
            said["limit"] = f"there are {rule.limit + surplus} detections; {taken}"
        width, height = frame.width, frame.height
        self._looked += bool(found)
        self._boxes += len(found)
        self._corners += sum(of_corners(each.box, width, height) is not None for each in found)
        if self._looked >= MANY and self._corners > self._boxes / 2:
            said["corners"] = (
                f"most boxes so far fit into the picture of {width}x{height} only as left, top, "
                f"right, bottom; a detector returns x, y, width, height"
            )
        least, most = rule.least or 0.0, max((each.score for each in found), default=0.0)
        if 0 < least < 1 and OTHER_SCALE < most < math.inf:
            said["scale"] = (
                f"a score is {most:g}, and detections.least is {least:g}, which keeps nearly all; "
                f"give both on one scale"
            )
        for kind, text in said.items():
            self._own_warnings.setdefault(kind, f"Frame {frame.index}: {text}.")

    def _check(self, frame: Frame) -> None:
        """Raise a SourceError if a frame cannot follow the last one."""
        last = self._last
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


def _in_order(pictures: Any, last: Frame | None) -> Iterator[Frame]:
    """Yield pictures as frames, each after the one before; raise a ConfigError for a single one."""
    shape = getattr(pictures, "shape", ())
    single = len(shape) == 2 or shape[2:] in ((3,), (4,))
    if single or isinstance(pictures, str) or not isinstance(pictures, Iterable):
        got = "one picture" if single else repr(pictures)
        raise ConfigError(f"Give the frames of a film, as of motes.open_source; got {got}.")
    for picture in pictures:
        last = as_frame(picture, last)
        yield last


def _broken(found: Detection) -> bool:
    """Return whether a detection is none: not finite, or without a size."""
    numbers = (*found.box, found.score)
    return not (all(map(math.isfinite, numbers)) and min(found.box[2:]) > 0)


def _checked(expected: Expected) -> Expected:
    """Return an expected object; raise a ConfigError if its numbers cannot be used."""
    velocity = np.asarray(expected.velocity, np.float64)
    if velocity.shape != (2,) or not (np.abs(velocity) <= FARTHEST).all():
        raise ConfigError(f"A velocity is two numbers, in pixels a second; got {velocity}.")
    return replace(expected, samples=as_samples(expected.samples), velocity=velocity)


def _homography(motion: Any) -> Floats | None:
    """Return a detector's motion; raise a ConfigError if it is no homography."""
    if motion is None:
        return None
    with contextlib.suppress(TypeError, ValueError):
        matrix = np.asarray(motion, np.float64)
        if matrix.shape == (3, 3) and np.isfinite(matrix).all() and np.linalg.det(matrix):
            return matrix
    raise ConfigError(
        f"The detector's motion is {' '.join(repr(motion).split())[:80]}; it must be a homography, "
        f"an array (3, 3), or None."
    )
