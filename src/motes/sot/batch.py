"""Several targets in one video: one tracker for each, over the same frames."""

from __future__ import annotations

from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from typing import Self

from motes.core.errors import ConfigError
from motes.core.frame import Frame
from motes.core.track import Track
from motes.sot.presets import TrackerConfig
from motes.sot.tracker import Picture, Tracker


class Trackers:
    """Follows several objects at once. They share each frame, and what cues compute from it.

    Object i has the same tracks as with `Tracker(config, seed + i)` alone, to the last bit, for any
    number of threads. With several threads, use it in a `with` statement, or call `close`.

    Parameters
    ----------
    config, seed
        As for `Tracker`.
    threads
        Number of threads that share the objects. They read pixels at the same time, so a second
        thread is faster with tens of objects, or with cues that read many pixels.
    """

    each: list[Tracker]
    """The trackers, in the order of the regions."""

    def __init__(
        self, config: str | TrackerConfig = "default", seed: int = 0, threads: int = 1
    ) -> None:
        if not isinstance(threads, int) or threads < 1:
            raise ConfigError(f"Objects are divided among 1 or more threads; got {threads}.")
        self._config, self._seed, self._threads = config, seed, threads
        self._pool = ThreadPoolExecutor(threads) if threads > 1 else None
        self._closed = False
        self.each = []

    def init(self, frame: Picture, regions: Sequence[Sequence[float]]) -> list[Track]:
        """Start on the objects in regions: boxes (x, y, w, h) or ellipses (x, y, a, b, theta).

        Raises
        ------
        ConfigError
            If there is no region, if one is not valid or does not fit the frame, or after `close`.
        """
        self._opened()
        if not hasattr(regions, "__len__") or not len(regions):
            raise ConfigError("There is nothing to follow; give at least one region.")
        picture = frame if isinstance(frame, Frame) else Frame(0, 0.0, frame)
        each = [Tracker(self._config, self._seed + i) for i in range(len(regions))]
        tracks = [tracker.init(picture, box) for tracker, box in zip(each, regions, strict=True)]
        self.each = each
        return tracks

    def update(self, frame: Picture) -> list[Track]:
        """Return the tracks in the next frame, in the order of the regions.

        Raises
        ------
        ConfigError
            Before `init` or after `close`.
        SourceError
            If the frame's size has changed, or its time is not after the last one's.
        """
        self._opened()
        if not self.each:
            raise ConfigError("There are no targets yet; call init first.")
        picture = self.each[0].picture(frame)
        if self._pool is None:
            return [tracker.update(picture) for tracker in self.each]
        # One task for each thread: one for each object would cost more than it saves.
        size = -(-len(self.each) // self._threads)
        parts = [self.each[i : i + size] for i in range(0, len(self.each), size)]
        done = self._pool.map(lambda part: [tracker.update(picture) for tracker in part], parts)
        return [track for tracks in done for track in tracks]

    def close(self) -> None:
        """Stop the threads; the trackers cannot be used afterwards."""
        self._closed = True
        if self._pool is not None:
            self._pool.shutdown()

    def _opened(self) -> None:
        if self._closed:
            raise ConfigError("These trackers are closed; make new ones.")

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *exception: object) -> None:
        self.close()
