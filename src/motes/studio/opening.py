"""How a worker opens its film: quickly, or as a whole where it is damaged."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import suppress

from motes.core.frame import FRAME_INTERVAL
from motes.studio.messages import OpenFilm
from motes.video.film import DamagedError, Film


def opened(path: str, check: Callable[[], None], *, whole: bool) -> Film:
    """Return a film.

    Parameters
    ----------
    path
        The film, which has been checked.
    check
        Called for each picture while the whole film is read.
    whole
        Whether it is read as a whole at once: it is known to be damaged.
    """
    if not whole:
        with suppress(DamagedError):
            return Film(path, quick=True)
    return Film(path, check=check)


def facts_of(film: Film) -> OpenFilm:
    """Return the size and length of a film."""
    fps = film.fps or 1 / FRAME_INTERVAL
    problems = None if film.quick else film.report.problems
    return OpenFilm(film.name, film.width, film.height, len(film.times), fps, problems)
