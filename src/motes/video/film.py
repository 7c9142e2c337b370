"""A recorded film whose frames can be read in any order, with little memory.

All pictures are decoded once, which gives an index of their times and of the key pictures. Frames
are then decoded again from the last key picture before them. Backward, this happens in parts of
bounded memory. What several passes read is decoded once, and held, where it fits.
"""

from __future__ import annotations

import bisect
import contextlib
import copy
from collections.abc import Callable, Generator, Iterable, Iterator
from pathlib import Path
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from motes.core.errors import ConfigError, SourceError
from motes.core.files import as_path
from motes.core.frame import Frame
from motes.core.interrupts import check
from motes.core.log import LOG
from motes.core.types import Bytes
from motes.video.decoder import Decoder
from motes.video.report import Load, Reader, Report, Stamped
from motes.video.sources import check_rate, even_rate, find_reader, is_recorded
from motes.video.times import AHEAD, timed

PART = 1 << 28
"""Bytes of decoded pictures that are held while a film is read backward; a pixel has three."""


class DamagedError(SourceError):
    """A film that was opened quickly is damaged; read as a whole, it may have other frames."""


class Film:
    """The frames of a video file or of images, in any order; as those of `open_source`.

    Raises a SourceError if there is nothing to read, or the source cannot be read twice; and a
    ConfigError if no frame is in the range.

    Parameters
    ----------
    source
        A video file, an image file, a folder or a pattern.
    start, end
        The frames that are used: from `start` on, before `end`.
    fps
        Frames per second, in place of the times in the file; as in `open_source`.
    quick
        Whether the times are taken from the packets of a video file, without decoding them. This
        takes a hundredth of the time. After a seek, only frames are decoded that others need. A
        damaged film has other frames then: a `DamagedError` comes when the first damage is met, and
        without `quick` there is none.
    check
        Called for each picture of which the time is read; it may raise to end this.

    Attributes
    ----------
    name
        The name in messages.
    times
        The time of each frame of the whole film before `end`, in seconds.
    width, height
        The size of a frame, in pixels.
    fps
        Nominal frames per second; None if unknown.
    even_rate
        Frames per second that give the times; None where the file has times of its own.
    quick
        Whether it was opened so.
    frames
        The indices of the frames that are used.
    files
        The paths of all image files in the folder that holds them, by frame; none of a video.
    report
        Counts of what was read and of errors.
    """

    def __init__(
        self,
        source: str | Path,
        *,
        start: int = 0,
        end: int | None = None,
        fps: float | None = None,
        quick: bool = False,
        check: Callable[[], None] = check,
    ) -> None:
        if not is_recorded(source):
            raise SourceError(
                f"{source} is read once, as it comes; record it first, and give the recording."
            )
        as_path(source)
        if start < 0 or (end is not None and end <= start):
            stop = "" if end is None else f" to {end}"
            raise ConfigError(
                f"No frame is from {start}{stop}; start at 0 or later, and end later."
            )
        check_rate(fps)
        fps = fps and float(fps)  # numpy's in 32 bits would let times run into each other
        self._source, self._rate, self.quick = str(source), fps, quick
        self.report, self.times, self._stamps = Report(), list[float](), list[float | None]()
        size: tuple[int, int] | None = None
        self._matrices: dict[int, NDArray[np.int32]] = {}
        self.name, reader = self._opened()
        if quick and isinstance(reader, Decoder) and (index := reader.index()) is not None:
            first, listed = self._first(index[0][0] if index else None), index
            reader.keys.extend(stamp for stamp, key in listed if key)
            pictures: Generator[Stamped, None, None] = ((stamp, first) for stamp, _ in listed)
        else:
            self.quick, pictures = False, reader.pictures(self.report)
        with contextlib.closing(reader), contextlib.closing(pictures) as all_:
            self.fps = fps or reader.fps
            ahead = AHEAD if isinstance(reader, Decoder) else 0
            even = fps is not None
            for moment, stamp, load in timed(all_, self.fps, self.report, even=even, ahead=ahead):
                if end is not None and len(self.times) >= end:
                    break
                if size is None:
                    size = load().shape[1::-1]
                self.times.append(moment)
                self._stamps.append(stamp)
                check()
            self.even_rate = even_rate(reader, fps, self.report)
            self._keys = reader.keys if isinstance(reader, Decoder) else []
        self.files = reader.files
        if size is None:
            raise SourceError(f"{self.name} holds no readable picture.")
        if not 0 <= start < len(self.times):
            raise ConfigError(
                f"{self.name} has {len(self.times)} frames, none of them from {start} on; choose "
                f"a smaller start."
            )
        self.width, self.height = size
        self.frames = range(start, len(self.times))
        known = [stamp for stamp in self._stamps if stamp is not None]
        if len(known) < len(self._stamps) or self.report.retimed or known != sorted({*known}):
            self._keys = []  # stamps do not identify frames: read from the beginning
        self._keys = sorted(self._keys)
        if assumption := self.report.assumption:
            LOG.warning("%s: %s", self.name, assumption)
        if problems := self.report.problems:
            LOG.warning("%s: %s.", self.name, problems)

    @classmethod
    def quickly(cls, source: str | Path, check: Callable[[], None] = check) -> Film:
        """Return a film that is opened quickly, or as a whole where its beginning is damaged."""
        try:
            return cls(source, quick=True, check=check)
        except DamagedError:
            return cls(source, check=check)

    def _opened(self) -> tuple[str, Reader]:
        """Return the film's name for messages, and a reader that knows what earlier ones found.

        So no decoder but the first reads a display matrix, which costs the memory of a picture.
        """
        name, reader = find_reader(self._source, fps=self._rate)
        if isinstance(reader, Decoder):
            reader.matrices = self._matrices
        return name, reader

    def _first(self, begin: float | None) -> Load:
        """Return a function that returns the pixels of the first picture, which is decoded here."""
        report = Report()
        _, reader = self._opened()
        with contextlib.closing(reader), contextlib.closing(reader.pictures(report)) as pictures:
            for stamp, load in pictures:
                if stamp != begin:
                    raise self._damaged()
                self.check_damage(report)
                pixels = load()
                self.report.depth = report.depth
                return lambda: pixels
        raise SourceError(f"{self.name} holds no readable picture.")

    def _damaged(self) -> DamagedError:
        return DamagedError(f"{self.name} is damaged; it is read as a whole, which takes longer.")

    def check_damage(self, report: Report) -> None:
        """Raise a `DamagedError` if a quick film has turned out to be damaged."""
        if self.quick and (report.skipped or report.damaged):
            raise self._damaged()

    @property
    def keys(self) -> list[int]:
        """The indices of the key pictures, which are quick to reach; empty if unknown."""
        places = {stamp: i for i, stamp in enumerate(self._stamps)}
        return [places[key] for key in self._keys if key in places]

    def stamps_to(self, index: int) -> tuple[float, float] | None:
        """Return the time stamps of a frame and of the key picture before it; None if unknown."""
        goal = self._stamps[index]
        if goal is None or not (before := bisect.bisect_right(self._keys, goal)):
            return None
        return goal, self._keys[before - 1]

    def decoder(self) -> Decoder:
        """Open the file of a video once more."""
        _, reader = self._opened()
        assert isinstance(reader, Decoder)  # images have no key pictures
        return reader

    def part(self, start: int, end: int) -> Film:
        """Return the same film with other frames: from `start` on, before `end`."""
        if not 0 <= start < end <= len(self.times):
            raise ConfigError(f"{self.name} has no frames {start} to {end - 1}.")
        twin = copy.copy(self)
        twin.frames = range(start, end)
        return twin

    def forward(self, first: int, last: int) -> Generator[Frame, None, None]:
        """Yield the frames from `first` to `last`."""
        with contextlib.closing(self.loads(first)) as loads:
            for index, load in loads:
                yield self.loaded(index, load)
                if index >= last:
                    return

    def backward(self, last: int, first: int) -> Generator[Frame, None, None]:
        """Yield the frames from `last` down to `first`."""
        held = max(PART // (3 * self.width * self.height), 1)
        while last >= first:
            low, part = max(first, last - held + 1), list[tuple[int, Load]]()
            with contextlib.closing(self.loads(low)) as loads:
                for index, load in loads:
                    part.append((index, load))
                    check()
                    if index >= last:
                        break
                while part:
                    yield self.loaded(*part.pop())
            last = low - 1

    def frame(self, index: int) -> Frame:
        """Return one frame."""
        with contextlib.closing(self.forward(index, index)) as frames:
            return next(frames)

    def loaded(self, index: int, load: Load) -> Frame:
        """Return the frame of this index, given the function that loads its pixels."""
        pixels = load()
        if pixels.shape[1::-1] != (self.width, self.height):
            raise SourceError(
                f"Frame {index} of {self.name} has {pixels.shape[1]}x{pixels.shape[0]} pixels, the "
                f"first one {self.width}x{self.height}; split or rescale it."
            )
        return Frame(index, self.times[index], pixels)

    def loads(self, first: int) -> Generator[tuple[int, Load], None, None]:
        """Yield the index of each frame from `first` on, and a function that loads its pixels.

        A seek may end behind its goal. Then an earlier key picture is tried, at last the beginning.
        """
        goal = self._stamps[first]
        keys = [] if goal is None else self._keys[: bisect.bisect_right(self._keys, goal)]
        found = False
        while not found:
            # The first key is the beginning.
            key = keys.pop() if len(keys) > (not self.quick) else None
            report = Report()
            _, reader = self._opened()
            with contextlib.closing(reader):
                pictures = reader.pictures(report)
                if key is not None and goal is not None and isinstance(reader, Decoder):
                    reader.seek(key)
                    if self.quick:
                        pictures = reader.pictures_from(goal, report)
                with contextlib.closing(pictures):
                    for index, load in self._numbered(pictures, first if key is not None else None):
                        self.check_damage(report)
                        if index >= first:
                            found = True
                            yield index, load
                    if found and self.quick:
                        self.check_damage(report)
                        if index + 1 < len(self.times):
                            raise self._damaged()
            if key is None and not found:
                self.check_damage(report)
                raise SourceError(f"{self.name} has fewer frames than before; was it changed?")

    def _numbered(
        self, pictures: Iterable[Stamped], first: int | None
    ) -> Iterator[tuple[int, Load]]:
        """Yield the index of each picture: from 0, or from `first` on, found by its stamp.

        There is none if the pictures begin behind `first`.
        """
        index = 0 if first is None else -1
        for stamp, load in pictures:
            if first is not None and index < 0:
                if stamp is None or stamp < self._stamps[first]:  # type: ignore[operator]
                    continue
                index = first
                if stamp != self._stamps[first]:
                    return
            if index == len(self.times):
                return
            if stamp != self._stamps[index]:
                if self.quick:
                    raise self._damaged()
                raise SourceError(
                    f"{self.name} reads differently the second time, at frame {index}; convert it "
                    f"first."
                )
            yield index, load
            index += 1


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
