"""Tracker: a thin shell that feeds frames to a tracking algorithm, one at a time."""

from __future__ import annotations

import copy
import json
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any, Never, Self, TypeVar

import msgspec
import numpy as np
from msgspec.structs import replace
from numpy.typing import NDArray

from motes.core.config import checked_seed
from motes.core.decode import MisfitError, decode
from motes.core.detection import Detector, as_detections, best, check_callable
from motes.core.errors import ConfigError, FormatError, SourceError
from motes.core.files import as_path, write_whole
from motes.core.frame import Frame, as_frame
from motes.core.geometry import as_samples, check_angle, region_within
from motes.core.log import LOG
from motes.core.saved_state import UNREADABLE, sealed, unpack, unsealed
from motes.core.track import Status, Track
from motes.core.types import Bytes, Floats, Numbers
from motes.sot.algorithm import Algorithm, StepInfo
from motes.sot.bare import bare_note, cut_note
from motes.sot.discriminative.tracker import Discriminative
from motes.sot.known_target import KnownTarget, Place, boxes_of
from motes.sot.network.network import Network
from motes.sot.particle_filter import ParticleFilter
from motes.sot.presets import TrackerConfig, preset

Picture = Frame | NDArray[Any]


def alone(more: tuple[object, ...]) -> None:
    """Raise a ConfigError if more than a region is given."""
    if more:
        raise ConfigError("Give the region alone: its frame is the last one of init or update.")


class Tracker:
    """Follows one object from frame to frame.

    Frames are `Frame`s, or images as `as_rgb` takes them. An image is taken to follow 1/25 s after
    the one before.

    Parameters
    ----------
    config
        A preset's name or a configuration.
    seed
        Seed of the random numbers; the same seed gives the same tracks to the last bit.
    backward
        Whether frames come in reverse order, each before the last one. The algorithm sees the film
        run backward; tracks have the times of their frames.
    network
        Files of a trained network that joins the default tracker (docs/network.md), in a sequence,
        or in a text with commas between them.
    """

    info: StepInfo
    """What happened in the last step."""

    def __init__(
        self,
        config: str | TrackerConfig = "default",
        seed: int = 0,
        *,
        backward: bool = False,
        network: str | Sequence[str] = (),
    ) -> None:
        self.config = preset(config) if isinstance(config, str) else config
        if not isinstance(self.config, Algorithm):
            raise ConfigError(f"Give a preset's name or a configuration; got {config!r}.")
        if network:
            if not isinstance(self.config, Discriminative):
                raise ConfigError("Only preset default takes a network; choose preset default.")
            self.config = replace(self.config, network=Network.named(network))
        if isinstance(self.config, Discriminative) and self.config.network:
            self.config.network.open()
        self._seed = checked_seed(seed)
        self._identity = 1  # in its tracks; another one among several trackers
        self._direction = -1 if backward else 1
        self._state: Any = None
        self._expected: Floats | None = None
        self._angle = 0.0
        self._restart()

    def init(self, frame: Picture, region: Numbers) -> Track:
        """Start on the object in `region`: a box (x, y, w, h) or an ellipse (x, y, a, b, theta).

        Numbers are in pixels, theta is in radians. A region that looks like what is around it
        holds nothing to follow, and one at the border may be cut: the logger `motes` warns of it,
        and so does `info.note`.

        Raises
        ------
        ConfigError
            If the region is not valid, or does not fit the frame.
        """
        picture = as_frame(frame)
        ellipse = region_within(region, picture.width, picture.height)
        check_angle(ellipse.theta)
        self._restart()
        state, info = self.config.init(self._rng, self._seen(picture), ellipse)
        note = bare_note(picture, ellipse) or cut_note(picture, ellipse)
        if note is not None:
            LOG.warning(note)
            info = replace(info, note=note)
        return self._take(picture, (state, info), ellipse.theta)

    def learn_also(self, frame: Picture, region: Numbers) -> None:
        """Learn how the target looks in another frame of the video, right after `init`.

        Each look has half of the learned models. The target stays where it is.

        Raises
        ------
        ConfigError
            Before `init` or `search`, or if the region is not valid or does not fit the frame.
        """
        state, _ = self._started()
        picture = as_frame(frame)
        ellipse = region_within(region, picture.width, picture.height)
        self._state = self.config.learn_also(state, picture, ellipse)

    def detect(self, frame: Picture, detector: Detector) -> Track | None:
        """Start on the detection with the highest score in a frame; return None without one.

        A detector is any callable from a `Frame` to a list of `Detection`s, or to another of the
        forms of `as_detections`.

        Raises
        ------
        ConfigError
            If it is none, or returns something else.
        """
        check_callable(detector)
        picture = as_frame(frame)
        found = best(as_detections(detector(picture)), picture)
        if found is None:
            return None
        return self.init(picture, found.box)

    def search(
        self,
        frame: Picture,
        target: KnownTarget,
        places: Sequence[Place] = (),
        background: Picture | None = None,
    ) -> Track:
        """Start by searching for a known target.

        Parameters
        ----------
        frame
            The first frame.
        target
            The target; it must have been learned with the tracker's cues.
        places
            Where the target may appear; anywhere if empty.
        background
            An image without the target; by default the first frame.

        Raises
        ------
        ConfigError
            If the tracker cannot search, or has other cues or bins than the target.
        """
        config = self.config
        if not isinstance(config, ParticleFilter):
            raise ConfigError(
                "Only a particle filter can search for a known target; choose preset nummiaro, or "
                "another one."
            )
        if not (isinstance(target, KnownTarget) and all(isinstance(p, Place) for p in places)):
            raise ConfigError("Search for a KnownTarget, at Places; init takes a region.")
        models = target.models_for(config.cues)
        picture = as_frame(frame)
        middle = target.size._replace(x=picture.width / 2, y=picture.height / 2)
        size = region_within(middle, picture.width, picture.height)
        boxes = boxes_of(tuple(places), picture) if places else None
        empty = None if background is None else as_frame(background)
        self._restart()
        begun = config.search(self._rng, self._seen(picture), models, size, boxes, empty)
        return self._take(picture, begun, size.theta)

    def expect(self, samples: Floats) -> None:
        """Look for the target at ellipses (N, 5) first in the next frame, if it is searched for.

        Another camera has seen the target there: Nummiaro et al., section VII.

        Raises
        ------
        ConfigError
            If the tracker is no particle filter, or one of the ellipses is none.
        """
        if not isinstance(self.config, ParticleFilter):
            raise ConfigError("Only a particle filter takes samples; choose preset nummiaro.")
        self._expected = as_samples(samples)

    def update(self, frame: Picture) -> Track:
        """Return the track of the target in the next frame.

        Raises
        ------
        ConfigError
            Before `init` or `search`.
        SourceError
            If the frame's size has changed, or its time is not after the last one's.
        """
        picture = self._following(frame)
        return self._take(picture, self._stepped(picture))

    def _following(self, frame: Picture) -> Frame:
        """Return an image as the frame after the last one."""
        _, last = self._started()
        picture = as_frame(frame, last, self._direction)
        if picture.pixels.shape != last.pixels.shape:
            raise SourceError(
                f"Frame {picture.index} is {picture.width}x{picture.height}, the ones before were "
                f"{last.width}x{last.height}; start anew with init."
            )
        if not self._direction * (picture.time - last.time) > 0:
            order = "after" if self._direction > 0 else "before"
            raise SourceError(
                f"Frame {picture.index} at {picture.time:g} s does not come {order} {last.time:g} "
                f"s; give frames in order, start anew with init, or see Tracker's backward."
            )
        return picture

    def _stepped(self, picture: Frame, state: Any = None) -> tuple[Any, StepInfo]:
        """Return the step into a frame, from the last state or from another one like it."""
        state = self._state if state is None else state
        expected, self._expected = self._expected, None
        if expected is not None and isinstance(self.config, ParticleFilter):
            return self.config.step(self._rng, state, self._seen(picture), expected=expected)
        return self.config.step(self._rng, state, self._seen(picture))

    def correct(self, region: Numbers, *more: Never) -> Track:
        """Put the target at `region` of the last frame; the target model is kept.

        `region` is a box (x, y, w, h) or an ellipse (x, y, a, b, theta), in pixels and radians.

        Raises
        ------
        ConfigError
            Before `init` or `search`, or if the region is not valid or does not fit the frame.
        """
        alone(more)
        state, last = self._started()
        ellipse = region_within(region, last.width, last.height)
        corrected = self.config.correct(state, self._seen(last), ellipse)
        return self._take(last, corrected, ellipse.theta)

    def save(self, path: str | Path) -> None:
        """Write all that the next call needs. After `load`, tracks continue to the last bit.

        Raises
        ------
        ConfigError
            Before `init` or `search`.
        FormatError
            If the file cannot be written.
        """
        save_plain(path, self._plain())

    def _plain(self) -> dict[str, Any]:
        """Return what `save` writes."""
        state, last = self._started()
        plain = {
            "config": self.config.to_dict(),
            "seed": self._seed,
            "random": json.dumps(self._rng.bit_generator.state),
            "frame": [last.index, last.time, last.pixels],
            "angle": self._angle,
            "state": state,
        }
        if self._direction < 0:
            plain["backward"] = True
        if last.depth is not None:
            plain["depth"] = last.depth
        return plain

    @classmethod
    def load(cls, path: str | Path) -> Self:
        """Return a tracker that `save` has written; continue with `update`.

        Raises
        ------
        FormatError
            If the file cannot be read, is no saved tracker, or holds a state that does not belong
            to its configuration.
        """
        return load_plain(path, cls._of_plain)

    @classmethod
    def _of_plain(cls, plain: Any) -> Self:
        if "objects" in plain:
            raise ConfigError("it holds several targets, for Trackers.load")
        tracker = cls(decode(plain["config"], Algorithm), plain["seed"])
        tracker._direction = -1 if plain.get("backward") else 1
        saved = msgspec.convert(plain, _Saved, dec_hook=unpack)
        state: Any = msgspec.convert(saved.state, tracker.config.state_type, dec_hook=unpack)
        tracker._rng.bit_generator.state = json.loads(saved.random)
        index, seconds, pixels = saved.frame
        frame = Frame(index, seconds, pixels, depth=saved.depth)
        tracker._angle = saved.angle
        tracker._state = tracker.config.typed(state, tracker._seen(frame))
        tracker._frame = frame
        return tracker

    def __copy__(self) -> Self:
        """Return an independent tracker. States and frames never change, so both share them.

        `copy.copy` and `copy.deepcopy` do the same.
        """
        twin = object.__new__(type(self))
        twin.__dict__.update(self.__dict__)
        twin._rng = copy.deepcopy(self._rng)
        return twin

    def __deepcopy__(self, memo: dict[int, Any]) -> Self:
        return copy.copy(self)

    def _restart(self) -> None:
        self._rng = np.random.Generator(np.random.PCG64(self._seed))
        self._frame: Frame | None = None
        self._status: Status | None = None

    def _started(self) -> tuple[Any, Frame]:
        if self._state is None or self._frame is None:
            raise ConfigError("The tracker has no target yet; call init or search first.")
        return self._state, self._frame

    def _seen(self, frame: Frame) -> Frame:
        """Return a frame as the algorithm sees it: backward, times are negative and increase."""
        if self._direction > 0:
            return frame
        return Frame(frame.index, -frame.time, frame.pixels, frame.cache)

    def _take(
        self, frame: Frame, result: tuple[Any, StepInfo], angle: float | None = None
    ) -> Track:
        """Take over a step; its ellipse is turned from the last angle, or the given one."""
        self._state, self.info = result
        self._frame, track = frame, self.info.track
        if track.status is not self._status:
            LOG.info("Frame %d: the target is %s.", frame.index, track.status)
        self._status = track.status
        ellipse = track.ellipse.turned_near(self._angle if angle is None else angle)
        self._angle = ellipse.theta
        named = track.identity == self._identity
        if self._direction < 0 or not named or ellipse is not track.ellipse:
            track = replace(track, time=frame.time, ellipse=ellipse, identity=self._identity)
            self.info = replace(self.info, track=track)
        return track


FORMAT = 19
"""Version of the format of saved trackers."""
L = TypeVar("L")


def save_plain(path: str | Path, plain: dict[str, Any]) -> None:
    """Write plain values and arrays as a saved tracker."""
    try:
        write_whole(as_path(path), sealed(FORMAT, plain))
    except OSError as error:
        raise FormatError(f"Cannot write the tracker {path}: {error.strerror}.") from None


def load_plain(path: str | Path, make: Callable[[Any], L]) -> L:
    """Return what `make` makes of the plain values of a saved tracker."""
    file = as_path(path)
    try:
        plain = unsealed(FORMAT, file.read_bytes())
    except OSError as error:
        raise FormatError(f"Cannot read the tracker {path}: {error.strerror}.") from None
    except ValueError as error:
        raise FormatError(f"{path} {error}.") from None
    try:
        return make(plain)
    except UNREADABLE as error:
        if isinstance(error, MisfitError) and (
            error.unknown is not None or error.place[-1:] == ("type",)
        ):
            raise FormatError(
                f"{path} cannot be loaded ({error}); the package that adds it is missing, or the "
                f"file is damaged."
            ) from None
        reason = " ".join(str(error).split()) or type(error).__name__
        raise FormatError(f"{path} has no state of its configuration ({reason}).") from None


class _Saved(msgspec.Struct):
    """The content of a file without the configuration; `state` has the algorithm's type."""

    random: str
    frame: tuple[int, float, Bytes]
    angle: float
    state: Any
    depth: int | None = None
