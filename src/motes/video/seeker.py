"""Single frames of a film, in any order, soon."""

from __future__ import annotations

import bisect
from collections.abc import Generator

from motes.core.errors import SourceError
from motes.core.types import Bytes
from motes.video.decoder import Decoder
from motes.video.film import Film
from motes.video.report import Load, Report, Stamped


class Seeker:
    """Reads single frames of a film; its file stays open, at the place that was read last.

    What is decoded on the way begins at the last key picture before a frame, or at that place if it
    is nearer. Of a quick film, only pictures are decoded that others need. The pixels are those of
    `Film.frame`.
    """

    def __init__(self, film: Film) -> None:
        self._film = film
        self._decoder: Decoder | None = None
        self._pictures: Generator[Stamped, None, None] | None = None
        self._reached = 0.0
        self._report = Report()
        self._keys = [] if film.quick else film.keys
        self._loads: Generator[tuple[int, Load], None, None] | None = None
        self._next = 0

    def pixels(self, index: int) -> Bytes:
        """Return the pixels of a frame; raise a SourceError if it cannot be read."""
        stamps = self._film.stamps_to(index) if self._film.quick else None
        load = None if stamps is None else self._sought(*stamps)
        return self._film.loaded(index, load or self._read(index)).pixels

    def close(self) -> None:
        """Close the file."""
        self._leave()
        if self._loads is not None:
            self._loads.close()
        if self._decoder is not None:
            self._decoder.close()

    def _sought(self, goal: float, key: float) -> Load | None:
        """Return what loads the picture of a time stamp; None if a seek ends behind it."""
        if self._decoder is None:
            self._decoder = self._film.decoder()
        decoder = self._decoder
        if self._pictures is not None and key <= self._reached < goal:
            decoder.skip_to(goal)
        else:
            self._leave()
            decoder.seek(key)
            self._pictures = decoder.pictures_from(goal, self._report)
        stamp, load = next(self._pictures, (None, None))
        self._film.check_damage(self._report)
        if stamp != goal:
            self._leave()
            return None
        self._reached = goal
        return load

    def _leave(self) -> None:
        if self._pictures is not None:
            self._pictures.close()
            self._pictures = None

    def _read(self, index: int) -> Load:
        """Return what loads the picture of a frame, in a film of which all is decoded."""
        nearer = bisect.bisect_right(self._keys, index) > bisect.bisect_left(self._keys, self._next)
        if self._loads is None or index < self._next or nearer:
            self._loads = self._film.loads(index)
        for found, load in self._loads:
            self._next = found + 1
            if found == index:
                return load
        self._loads = None
        raise SourceError(f"Frame {index} of {self._film.name} cannot be read; convert the film.")
