"""Several targets in one video: one tracker for each, over the same frames."""

from __future__ import annotations

import copy
import os
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from functools import partial
from pathlib import Path
from typing import Annotated, Any, Never, Self

import msgspec
from msgspec import Meta
from numpy.typing import NDArray

from motes.core.decode import decode
from motes.core.errors import ConfigError
from motes.core.frame import WHOLE, Frame, as_frame, from_bgr
from motes.core.track import Track
from motes.core.types import Numbers
from motes.sot.algorithm import Algorithm, StepInfo
from motes.sot.presets import TrackerConfig
from motes.sot.tracker import Picture, Tracker, alone, load_plain, save_plain


class Trackers:
    """Follows several objects at once. They share each frame, and what cues compute from it.

    No two are at one place: where objects that were apart are found at one, it is that of the one
    that is most like itself there and moves on as before, and the others look elsewhere
    (`Algorithm.displaced`; preset default alone does so). Objects that `init` or `add` places upon
    each other, such as a person and his shirt, may stay so (`Algorithm.stacked`). Where nobody
    meets, object i, counted from the first one that was ever added, has the same tracks as with
    `Tracker(config, seed + i)` alone, to the last bit, for any number of threads, but with
    the identity i + 1. With several threads, use it in a `with` statement, or call `close`.

    Parameters
    ----------
    config, seed
        As for `Tracker`.
    threads
        Number of threads that share the objects. They read pixels at the same time, so a second
        thread is faster with tens of objects, or with cues that read many pixels.
    bgr
        Whether images are BGR, as OpenCV reads them; `Frame`s are RGB always.

    Raises
    ------
    ConfigError
        As from `Tracker`, or if the number of threads is none.
    """

    each: list[Tracker]
    """The trackers, in the order in which they were added.

    `each[0].correct(region)` puts the first object at its true place. To follow another object in
    place of one, `remove` it, and `add` that.
    """

    def __init__(
        self,
        config: str | TrackerConfig = "default",
        seed: int = 0,
        threads: int = 1,
        *,
        bgr: bool = False,
    ) -> None:
        if not isinstance(threads, WHOLE) or threads < 1:
            raise ConfigError(f"Objects are divided among 1 or more threads; got {threads!r}.")
        self._config, self._seed = Tracker(config, seed).config, seed  # a wrong name is refused now
        self._threads, self._bgr = threads, bgr
        self._pool: ThreadPoolExecutor | None = None
        self._owner = 0  # the process in which the pool has threads: a child of fork has none
        self._closed = False
        self._last: Frame | None = None
        self._begun = 0  # how many objects there have been
        self._stacked: set[tuple[int, int]] = set()  # who lie upon each other, by their seeds
        self.each = []

    def init(self, frame: Picture, regions: Sequence[Numbers] | NDArray[Any]) -> list[Track]:
        """Start on the objects in regions: boxes (x, y, w, h) or ellipses (x, y, a, b, theta).

        Raises
        ------
        ConfigError
            If there is no region, if one is not valid or does not fit the frame, or after `close`.
        """
        self._opened()
        if not hasattr(regions, "__len__") or any(not hasattr(r, "__len__") for r in regions):
            raise ConfigError(f"Give a list of regions; got {regions!r}.")
        if not len(regions):
            raise ConfigError("There is nothing to follow; give at least one region.")
        picture = self._picture(frame)
        each = [self._tracker(i) for i in range(len(regions))]
        tracks = [tracker.init(picture, box) for tracker, box in zip(each, regions, strict=True)]
        self.each, self._last, self._begun, self._stacked = [], picture, len(each), set()
        for tracker in each:
            self._append(tracker)
        return tracks

    def add(self, region: Numbers, *more: Never) -> Track:
        """Start on another object, in a region of the last frame. It comes last in `each`.

        That frame is read where it lies in memory: draw on a copy of it.

        Raises
        ------
        ConfigError
            Before `init`, after `close`, or if the region is not valid or does not fit the frame.
        """
        alone(more)
        last = self._started()
        tracker = self._tracker(self._begun)
        track = tracker.init(last, region)
        self._append(tracker)
        self._begun += 1
        return track

    def _tracker(self, number: int) -> Tracker:
        """Return the tracker of an object, whose identity tells its tracks from the others'."""
        tracker = Tracker(self._config, self._seed + number)
        tracker._identity = number + 1
        return tracker

    def _append(self, tracker: Tracker) -> None:
        """Take a tracker of an object of the last frame as the last one."""
        self._stacked = self._stacked | {
            (each._seed, tracker._seed)
            for each in self.each
            if self._config.stacked(each._state, tracker._state)
        }
        self.each.append(tracker)

    def remove(self, identity: int) -> None:
        """Follow the object no more whose tracks have an identity.

        Raises
        ------
        ConfigError
            If there is none, or after `close`.
        """
        self._opened()
        known = {each._identity: each for each in self.each}
        if identity not in known:
            identities = ", ".join(map(str, known)) or "none"
            raise ConfigError(f"There is no object {identity}; the identities are {identities}.")
        self.each.remove(known[identity])

    def update(self, frame: Picture) -> list[Track]:
        """Return the tracks in the next frame, in the order of `each`.

        Raises
        ------
        ConfigError
            Before `init` or after `close`.
        SourceError
            If the frame's size has changed, or its time is not after the last one's.
        """
        picture = self._picture(frame, self._started())
        for tracker in self.each:
            tracker._following(picture)
        steps, before = self._steps(picture), [each._state for each in self.each]
        places = {tracker._seed: place for place, tracker in enumerate(self.each)}
        stacked = {
            (places[first], places[second])
            for first, second in self._stacked
            if first in places and second in places
        }
        for _ in self.each:  # who looks elsewhere may find a third one
            again = self._config.displaced(before, [state for state, _ in steps], stacked)
            for index, state in again.items():
                before[index], steps[index] = state, self.each[index]._stepped(picture, state)
            if not again:
                break
        self._last = picture
        return [each._take(picture, step) for each, step in zip(self.each, steps, strict=True)]

    def _steps(self, picture: Frame) -> list[tuple[Any, StepInfo]]:
        """Return the step of each tracker into a frame."""
        if self._threads == 1:
            return [tracker._stepped(picture) for tracker in self.each]
        # One task for each thread: one for each object would cost more than it saves.
        size = max(-(-len(self.each) // self._threads), 1)
        parts = [self.each[i : i + size] for i in range(0, len(self.each), size)]
        if self._pool is None or self._owner != os.getpid():
            self._pool, self._owner = ThreadPoolExecutor(self._threads), os.getpid()
        done = self._pool.map(lambda part: [each._stepped(picture) for each in part], parts)
        return [step for steps in done for step in steps]

    def close(self) -> None:
        """Stop the threads; the trackers cannot be used afterwards."""
        self._closed = True
        if self._pool is not None and self._owner == os.getpid():
            self._pool.shutdown()

    def save(self, path: str | Path) -> None:
        """Write all that the next call needs. After `load`, tracks continue to the last bit.

        Raises
        ------
        ConfigError
            Before `init`, after `close`, or if there is no object left.
        FormatError
            If the file cannot be written.
        """
        self._started()
        if not self.each:
            raise ConfigError("There is no object left to save; call add or init first.")
        objects = [tracker._plain() for tracker in self.each]
        frame, *_ = [plain.pop("frame") for plain in objects]  # the same for all
        config, stacked = self._config.to_dict(), sorted(self._stacked)
        saved = _SavedGroup(config, self._seed, self._begun, self._bgr, frame, objects, stacked)
        save_plain(path, msgspec.structs.asdict(saved))

    @classmethod
    def load(cls, path: str | Path, threads: int = 1) -> Self:
        """Return the trackers that `save` has written; continue with `update`.

        Raises
        ------
        FormatError
            If the file cannot be read, holds no saved trackers, or a state that does not belong to
            its configuration.
        """
        return load_plain(path, partial(cls._of_plain, threads))

    @classmethod
    def _of_plain(cls, threads: int, plain: Any) -> Self:
        if "objects" not in plain:
            raise ConfigError("it holds a single target, for Tracker.load")
        saved = msgspec.convert(plain, _SavedGroup)
        trackers = cls(decode(saved.config, Algorithm), saved.seed, threads, bgr=saved.bgr)
        for each in saved.objects:
            tracker = Tracker._of_plain({**each, "frame": saved.frame})
            tracker._identity = tracker._seed - saved.seed + 1
            trackers.each.append(tracker)
        trackers._last, trackers._begun = trackers.each[0]._frame, saved.begun
        trackers._stacked = {*saved.stacked}
        return trackers

    def _started(self) -> Frame:
        """Return the last frame."""
        self._opened()
        if self._last is None:
            raise ConfigError("There are no targets yet; call init first.")
        return self._last

    def _picture(self, frame: Picture, last: Frame | None = None) -> Frame:
        """Return an image as the frame after the last one, or as the first one."""
        bgr = self._bgr and not isinstance(frame, Frame)
        return as_frame(from_bgr(frame) if bgr else frame, last)  # type: ignore[arg-type]

    def _opened(self) -> None:
        if self._closed:
            raise ConfigError("These trackers are closed; make new ones.")

    def __getstate__(self) -> dict[str, Any]:
        """Return what an independent copy needs, also in another process, without threads."""
        return {**self.__dict__, "_pool": None, "each": [copy.copy(each) for each in self.each]}

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *exception: object) -> None:
        self.close()


class _SavedGroup(msgspec.Struct):
    """The content of a file of several trackers, which share a configuration and a frame."""

    config: Any
    seed: int
    begun: Annotated[int, Meta(ge=1)]
    bgr: bool
    frame: Any
    objects: Annotated[list[dict[str, Any]], Meta(min_length=1)]
    stacked: list[tuple[int, int]]
