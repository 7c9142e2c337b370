"""Frames of a film that several passes read: decoded once, and held."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Protocol

from motes.core.frame import Frame
from motes.core.interrupts import check
from motes.core.types import Bytes
from motes.video.film import Film

HELD = 1 << 29
"""Bytes of pixels that are held at most: 86 frames of 1920x1080."""


class FrameReader(Protocol):
    """Frames in any order; `Film` and `Shared` are two."""

    def forward(self, first: int, last: int) -> Iterator[Frame]:
        """Yield the frames from `first` to `last`."""

    def backward(self, last: int, first: int) -> Iterator[Frame]:
        """Yield the frames from `last` down to `first`."""


class Shared:
    """The frames of a film from `first` to `last`, decoded when one of them is first read.

    Each reader gets frames of its own, with the same pixels.
    """

    def __init__(self, film: Film, first: int, last: int) -> None:
        self._film, self._first, self._last = film, first, last
        self._pixels: list[Bytes] = []

    def forward(self, first: int, last: int) -> Iterator[Frame]:
        """Yield the frames from `first` to `last`."""
        return map(self._frame, range(first, last + 1))

    def backward(self, last: int, first: int) -> Iterator[Frame]:
        """Yield the frames from `last` down to `first`."""
        return map(self._frame, range(last, first - 1, -1))

    def _frame(self, index: int) -> Frame:
        if not self._pixels:
            self._pixels = [*self._decoded()]
        return Frame(index, self._film.times[index], self._pixels[index - self._first])

    def _decoded(self) -> Iterator[Bytes]:
        for frame in self._film.forward(self._first, self._last):
            yield frame.pixels
            check()


def fits(frames: int, width: int, height: int) -> bool:
    """Return whether the pixels of a number of frames may be held."""
    return frames * 3 * width * height <= HELD


def shared(film: Film, first: int, last: int) -> FrameReader:
    """Return a reader of the frames from `first` to `last` for several passes over them.

    It decodes each frame once if all of them may be held, else once for each pass.
    """
    return Shared(film, first, last) if fits(last - first + 1, film.width, film.height) else film
