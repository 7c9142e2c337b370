"""Frames of a film that several passes read: decoded once, and held."""

from __future__ import annotations

import contextlib
from collections.abc import Iterator
from typing import Protocol

from motes.core.frame import Frame
from motes.core.interrupts import check
from motes.video.decoder import Load
from motes.video.film import Film

HELD = 1 << 29
"""Bytes of the pictures that are held, as pixels of three bytes. Most decoders give half of that."""


class FrameReader(Protocol):
    """Frames in any order; `Film` and `Shared` are two."""

    def forward(self, first: int, last: int) -> Iterator[Frame]:
        """Yield the frames from `first` to `last`."""

    def backward(self, last: int, first: int) -> Iterator[Frame]:
        """Yield the frames from `last` down to `first`."""


class Shared:
    """The frames of a film from `first` to `last`, decoded when the first one of them is read.

    What is held is what the decoder gave; each reader gets pixels of its own.
    """

    def __init__(self, film: Film, first: int, last: int) -> None:
        self._film, self._first, self._last = film, first, last
        self._loads: list[Load] = []

    def forward(self, first: int, last: int) -> Iterator[Frame]:
        """Yield the frames from `first` to `last`."""
        return (self._frame(index) for index in range(first, last + 1))

    def backward(self, last: int, first: int) -> Iterator[Frame]:
        """Yield the frames from `last` down to `first`."""
        return (self._frame(index) for index in range(last, first - 1, -1))

    def _frame(self, index: int) -> Frame:
        if not self._loads:
            self._loads = [*self._decoded()]
        return self._film.loaded(index, self._loads[index - self._first])

    def _decoded(self) -> Iterator[Load]:
        with contextlib.closing(self._film.loads(self._first)) as loads:
            for index, load in loads:
                yield load
                check()
                if index >= self._last:
                    return


def fits(frames: int, width: int, height: int) -> bool:
    """Return whether so many frames of this size may be held."""
    return frames * 3 * width * height <= HELD


def shared(film: Film, first: int, last: int) -> FrameReader:
    """Return a reader of the frames from `first` to `last` for several passes over them.

    It decodes each frame once if all of them may be held, else once for each pass.
    """
    return Shared(film, first, last) if fits(last - first + 1, film.width, film.height) else film
