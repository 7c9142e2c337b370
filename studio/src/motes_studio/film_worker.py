"""The worker of a film, seen from the server: tasks go in, answers come out, limits are kept."""

from __future__ import annotations

import asyncio
import multiprocessing
import threading
from collections.abc import Callable
from contextlib import suppress
from functools import partial
from pathlib import Path
from typing import Any

from motes import MotesError
from motes.core import Answer, Done, Failed, Part, Worker, blocked_signals, explain
from motes.video import DamagedError
from motes_studio.safety import Limits
from motes_studio.workplace import Task, Workplace, open_film

NICENESS = 10
"""Of work in the background, so that pictures and the server come first."""


class WorkerError(MotesError):
    """A worker has failed, or has ended."""


class EndedError(WorkerError):
    """A worker was ended: its task took too much time, or memory."""


class LaterError(WorkerError):
    """The film is read anew; who asks again gets an answer."""


def worker_context() -> Any:
    """Return how processes are started: as copies of one that has imported what they need."""
    if "forkserver" not in multiprocessing.get_all_start_methods():  # as on Windows
        return multiprocessing.get_context("spawn")
    context = multiprocessing.get_context("forkserver")
    context.set_forkserver_preload(["motes_studio.pictures", "motes_studio.tracking"])
    return context


def prepare() -> None:
    """Let the process that is copied begin with its imports, before the first session needs it."""
    if worker_context().get_start_method() == "forkserver":
        from multiprocessing import forkserver

        with blocked_signals():
            forkserver.ensure_running()


class FilmWorker:
    """A worker that opens a film, and then does one task at a time.

    In the `background`, pictures and the server come first. The film may be known to be damaged,
    and is read as a `whole` then; `damaged` is called if it turns out to be.
    """

    def __init__(
        self,
        path: Path,
        limits: Limits,
        *,
        background: bool = True,
        whole: bool = False,
        damaged: Callable[[], None] = lambda: None,
    ) -> None:
        self._path, self._limits, self._damaged = path, limits, damaged
        self._name = path.name
        self._answers: asyncio.Queue[Answer | str] = asyncio.Queue()
        """Answers, and in the end in words how the process has ended."""
        self._loop = asyncio.get_running_loop()
        self._turn = asyncio.Lock()
        self.ended = self._closed = False
        self._worker = Worker(line=Workplace, context=worker_context())
        threading.Thread(target=self._listen, daemon=True).start()
        niceness = NICENESS if background else 0
        opening = partial(open_film, path=str(path), limits=limits, whole=whole, niceness=niceness)
        self._worker.give(opening)
        self._opening = asyncio.create_task(self._result())
        self._opening.add_done_callback(self._opened)

    async def ready(self) -> bytes:
        """Wait until the film is open, and return an `Opened`; raise a WorkerError if it fails."""
        return await asyncio.shield(self._opening)

    def _opened(self, opening: asyncio.Task[bytes]) -> None:
        if opening.cancelled() or opening.exception():  # nobody may wait for it any more
            self._kill()

    async def run(self, task: Task, part: Callable[[bytes], None] | None = None) -> bytes:
        """Do a task, and return its data; `part` takes what comes before. Others wait.

        If this is cancelled, the task is stopped, and the next one waits for that; a task that has
        not begun then never begins.

        Raises
        ------
        WorkerError
            If it fails, or the process ends.
        """
        await self.ready()
        await self._turn.acquire()
        self._worker.give(task)
        running = asyncio.create_task(self._result(part))
        running.add_done_callback(self._end_turn)
        try:
            return await asyncio.shield(running)
        except asyncio.CancelledError:
            if not running.done():  # else it may be the turn of the next one
                self._worker.stop()
            raise

    def _end_turn(self, ended: asyncio.Task[bytes]) -> None:
        self._turn.release()
        if not ended.cancelled():
            ended.exception()  # nobody may wait for it any more

    async def _result(self, part: Callable[[bytes], None] | None = None) -> bytes:
        """Return the result of the task that the worker has been given."""
        try:
            while not isinstance(answer := await self._answer(), Done | Failed):
                if isinstance(answer, Part) and part is not None:
                    part(answer.data)
        except Exception as error:  # nobody takes the rest of the answers
            self._kill()
            if isinstance(error, MotesError):
                raise
            raise WorkerError(f"{self._name} has spoilt its worker ({explain(error)}).") from None
        if isinstance(answer, Done):
            return answer.data
        said = answer.error.replace(str(self._path), self._name)  # pages see no folders of ours
        if answer.kind == DamagedError.__name__:
            self._damaged()
            raise LaterError(said)
        raise (EndedError if answer.kind == MemoryError.__name__ else WorkerError)(said)

    def close(self) -> None:
        """End the process; nobody waits for it any more."""
        self._closed = True
        self._kill()

    def _kill(self) -> None:
        if not self.ended:
            self.ended = True
            self._worker.kill()

    async def _answer(self) -> Answer:
        try:
            answer = await asyncio.wait_for(self._answers.get(), self._limits.silence)
        except TimeoutError:
            raise EndedError(
                f"{self._name} kept its worker busy for {self._limits.silence:g} s without a "
                "result, so that worker was ended; convert the film."
            ) from None
        if not isinstance(answer, str):
            return answer
        if self._closed:
            raise LaterError(f"{self._name} was closed meanwhile; open it again.")
        raise EndedError(f"{self._name} has ended its worker ({answer}); convert the film.")

    def _listen(self) -> None:
        """Take answers until the process has ended; in a thread."""
        while (answer := self._worker.receive()) is not None:
            self._put(answer)
        how = self._worker.cause()
        self._worker.end()
        self._put(how)

    def _put(self, answer: Answer | str) -> None:
        with suppress(RuntimeError):  # the loop is closed: the server ends
            self._loop.call_soon_threadsafe(self._answers.put_nowait, answer)
