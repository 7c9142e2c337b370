"""Parts of sequences, for experiments on their first frames."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from motes import Frame, SourceError, open_source
from motes_lab.datasets.sot import Sequence


@dataclass(frozen=True, slots=True, eq=False)
class ShortSequence(Sequence):
    """A part of a sequence."""

    start: int
    every: int
    """The first frame of the source, and the distance from one frame to the next."""


def shortened(film: Sequence, frames: int, every: int) -> ShortSequence | None:
    """Return a film from the first frame with the target on; None if there is none.

    Parameters
    ----------
    film
        The film.
    frames
        Most frames of the result.
    every
        Their distance in the film: with 3, every third one.
    """
    there = np.flatnonzero(np.isfinite(film.boxes).all(axis=1))
    if not there.size:
        return None
    start = int(there[0])
    chosen = slice(start, start + every * frames, every)
    return ShortSequence(
        film.name, film.source, film.boxes[chosen], film.ellipses[chosen], start, every
    )


def frames_of(film: ShortSequence) -> Iterator[Frame]:
    """Yield the frames of a part, numbered from 0; raise a SourceError if there are too few."""
    end = film.start + film.every * (film.frames - 1) + 1
    with open_source(film.source, start=film.start, end=end, stride=film.every) as source:
        count, first_time = 0, math.nan
        for frame in source:
            first_time = frame.time if count == 0 else first_time
            yield Frame(count, frame.time - first_time, frame.pixels)
            count += 1
        if count < film.frames:
            raise SourceError(f"{source.name} ends before its truth does.")
