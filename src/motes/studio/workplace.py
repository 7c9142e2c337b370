"""Where tasks are done: a worker, its film, and its line to the server.

A task is a function at the top level of a module: it gets the workplace and returns bytes. The
server sends it as a `partial` with its other arguments, pickled. Answers are never pickled: a film
may have taken its worker over.
"""

from __future__ import annotations

import contextlib
import ctypes
import functools
import gc
import os
import time
from collections.abc import Callable
from multiprocessing.connection import Connection
from typing import Any

import msgspec

from motes.core.frame import FRAME_INTERVAL
from motes.core.import_callable import explain
from motes.core.system import system
from motes.studio.containers import check_container, check_limits
from motes.studio.messages import OpenFilm, Overlay
from motes.studio.safety import Limits
from motes.video.film import DamagedError, Film
from motes.video.seeker import Seeker

NICENESS = 10
"""Of work in the background, so that pictures and the server come first."""
TIDY = 1.0
"""Seconds of work after which a worker gives memory back."""

Opened = tuple[OpenFilm, list[float]]
"""A film that is open, and the times of its frames; the data of `open_film`."""


class Part(msgspec.Struct, frozen=True, tag=True):
    """Some of the result: rows of pass number `run`, or a part of a scene; and an overlay."""

    data: bytes
    run: int = 0
    overlay: Overlay | None = None


class Alive(msgspec.Struct, frozen=True, tag=True):
    """The worker goes on."""


class Done(msgspec.Struct, frozen=True, tag=True):
    """The task is done, or was stopped."""

    data: bytes = b""


class Failed(msgspec.Struct, frozen=True, tag=True):
    """The task has failed, with one line for a person.

    If `damaged`, the film is, and has to be read as a whole by a new worker.
    """

    error: str
    damaged: bool = False


Answer = Part | Alive | Done | Failed


class StoppedError(Exception):
    """The server wants the task to end."""


class Workplace:
    """A worker's film, and its line to the server.

    Parameters
    ----------
    pipe
        Of tasks and answers.
    stop
        Whether the server wants the task to end, in shared memory.
    """

    def __init__(self, pipe: Connection, stop: Any) -> None:
        self._pipe, self._stop = pipe, stop
        self._sent = 0.0
        self.film: Film
        """The film, once `open_film` has been done."""

    @functools.cached_property
    def seeker(self) -> Seeker:
        """Reads single frames."""
        return Seeker(self.film)

    def send(self, answer: Answer) -> None:
        """Send an answer."""
        self._pipe.send_bytes(msgspec.msgpack.encode(answer))
        self._sent = time.monotonic()

    def receive(self) -> Task:
        """Wait for the next task."""
        task: Task = self._pipe.recv()
        return task

    def check(self) -> None:
        """Give a sign of life each second; raise `StoppedError` if the task is to end."""
        if time.monotonic() - self._sent > 1:
            self.send(Alive())
        if self._stop.value:
            raise StoppedError


Task = Callable[[Workplace], bytes]


def open_film(place: Workplace, path: str, limits: Limits, *, whole: bool) -> bytes:
    """Open a film, quickly, or as a whole where it is damaged; return an `Opened`.

    Parameters
    ----------
    place
        Where it is needed.
    path
        The film.
    limits
        Of its size.
    whole
        Whether it is known to be damaged.

    Raises
    ------
    SourceError
        If it cannot be read.
    ConfigError
        If it is larger than the limits.
    """
    check_container(path, limits)
    try:
        film = Film(path, quick=not whole, check=place.check)
    except DamagedError:
        film = Film(path, check=place.check)
    check_limits(film.name, film.width, film.height, len(film.times), limits)
    place.film = film
    fps = film.fps or 1 / FRAME_INTERVAL
    problems = None if film.quick else film.report.problems
    facts = OpenFilm(film.name, film.width, film.height, len(film.times), fps, problems)
    return msgspec.msgpack.encode((facts, film.times))


def main(pipe: Connection, stop: Any, memory: int, background: bool) -> None:
    """Do tasks until the pipe is closed, with so much memory; the first one opens the film."""
    system.limit_memory(memory)
    if background:
        system.lower_priority(NICENESS)
    place = Workplace(pipe, stop)
    with contextlib.suppress(EOFError, OSError, KeyboardInterrupt):
        worked = 0.0
        while True:
            task = place.receive()
            begun = time.monotonic()
            try:
                place.send(Done(task(place)))
            except StoppedError:
                place.send(Done())
            except DamagedError as error:
                place.send(Failed(text_of(error), damaged=True))
            except Exception as error:  # a damaged film may cause any
                place.send(Failed(text_of(error)))
            del task
            worked += time.monotonic() - begun
            if worked > TIDY:
                give_back()
                worked = 0.0


def text_of(error: BaseException) -> str:
    """Return an error in one line."""
    if isinstance(error, MemoryError):
        return "This needs more memory than a worker may have; make the film or network smaller."
    return explain(error)


def give_back() -> None:
    """Give memory that is not needed any more back to the system.

    A decoder holds its pictures in circles of references, and the C library keeps what was freed:
    without this, a worker stays as large as in its longest task, and grows.
    """
    gc.collect()
    trim = getattr(ctypes.CDLL(None), "malloc_trim", None) if os.name == "posix" else None
    if trim is not None:
        trim(0)
