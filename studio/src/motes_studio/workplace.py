"""Where tasks are done: a worker's film, and its line to the server.

A task is a function at the top level of a module: it gets the workplace and returns bytes. The
server gives it as a `partial` with its other arguments.
"""

from __future__ import annotations

import ctypes
import functools
import os
import sys
from collections.abc import Callable

import msgspec

from motes.core import FRAME_INTERVAL, WorkerLine
from motes.rows import text_name
from motes.video import Film, Seeker
from motes_studio.containers import check_container, check_limits
from motes_studio.messages import OpenFilm
from motes_studio.safety import Limits

Opened = tuple[OpenFilm, list[float], list[str]]
"""A film that is open, the times of its frames, and the names of its images; the data of
`open_film`."""


class Workplace(WorkerLine):
    """The line of a worker that has a film."""

    film: Film
    """The film, once `open_film` has been done."""

    @functools.cached_property
    def seeker(self) -> Seeker:
        """Reads single frames."""
        return Seeker(self.film)


Task = Callable[[Workplace], bytes]
BELOW_NORMAL = 0x4000
"""A class of priorities of Windows."""


def limit_process(memory: int, niceness: int = 0) -> None:
    """Limit this process to some bytes of memory, without a dump; let others go before it.

    Windows has no such limit of memory.
    """
    if sys.platform != "win32":
        import resource

        resource.setrlimit(resource.RLIMIT_AS, (memory, memory))
        resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
        if niceness:
            os.nice(niceness)
    elif niceness:
        kernel = ctypes.windll.kernel32
        kernel.SetPriorityClass(kernel.GetCurrentProcess(), BELOW_NORMAL)


def open_film(place: Workplace, path: str, limits: Limits, *, whole: bool, niceness: int) -> bytes:
    """Open a film, quickly, or as a whole where it is damaged; return an `Opened`.

    It is the first task of a worker, and limits it: its memory, and how far others go before it
    (`niceness`). The film is read as a `whole` if it is known to be damaged.

    Raises
    ------
    SourceError
        If it cannot be read.
    ConfigError
        If it is larger than the limits.
    """
    limit_process(limits.memory, niceness)
    check_container(path, limits)
    opened = Film if whole else Film.quickly
    film = opened(path, check=place.check)
    check_limits(film.name, film.width, film.height, len(film.times), limits)
    place.film = film
    fps = film.fps or 1 / FRAME_INTERVAL
    problems = None if film.quick else film.report.problems
    facts = OpenFilm(film.name, film.width, film.height, len(film.times), fps, problems)
    return msgspec.msgpack.encode((facts, film.times, [*map(text_name, film.files)]))
