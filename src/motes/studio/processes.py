"""Worker processes, seen from the server: tasks go in, answers come out, and limits are kept."""

from __future__ import annotations

import asyncio
import multiprocessing
import threading
from collections.abc import Callable
from contextlib import suppress
from functools import partial
from multiprocessing.connection import Connection
from pathlib import Path
from typing import Any

import msgspec

from motes.core.errors import MotesError
from motes.core.worker_processes import blocked_signals, cause, started
from motes.studio.safety import Limits
from motes.studio.workplace import Answer, Done, Failed, Part, Task, main, open_film


class WorkerError(MotesError):
    """A worker has failed, or has ended."""


def worker_context() -> Any:
    """Return how processes are started: as copies of one that has imported what they need."""
    if "forkserver" not in multiprocessing.get_all_start_methods():  # as on Windows
        return multiprocessing.get_context("spawn")
    context = multiprocessing.get_context("forkserver")
    context.set_forkserver_preload(["motes.studio.pictures", "motes.studio.tracking"])
    return context


def prepare() -> None:
    """Let the process that is copied begin with its imports, before the first session needs it."""
    if worker_context().get_start_method() == "forkserver":
        from multiprocessing import forkserver

        with blocked_signals():
            forkserver.ensure_running()


class Worker:
    """A process that opens a film, and then does one task at a time.

    Parameters
    ----------
    path
        The film.
    limits
        Of its size, of memory, and of the time without a sign of life.
    background
        Whether pictures and the server come first.
    whole
        Whether the film is known to be damaged.
    damaged
        Called if it turns out to be.
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
        context = worker_context()
        self._name, self._limits = path.name, limits
        self._stop = context.Value("b", False, lock=False)
        self._answers: asyncio.Queue[Answer | None] = asyncio.Queue()
        self._loop = asyncio.get_running_loop()
        self._turn = asyncio.Lock()
        self._damaged = damaged
        self.ended = self._closed = False
        self._process, self._pipe = started(
            main, self._stop, limits.memory, background, context=context
        )
        threading.Thread(target=self._read, args=(self._pipe,), daemon=True).start()
        opening = partial(open_film, path=str(path), limits=limits, whole=whole)
        self._ready: asyncio.Task[bytes] = asyncio.create_task(self._opened(opening))
        self._ready.add_done_callback(lambda task: task.cancelled() or task.exception())

    @property
    def pid(self) -> int:
        """The number of the process."""
        return self._process.pid or 0

    async def ready(self) -> bytes:
        """Wait until the film is open, and return an `Opened`; raise a WorkerError if it fails."""
        try:
            return await asyncio.shield(self._ready)
        except asyncio.CancelledError:
            me = asyncio.current_task()
            if self._ready.cancelled() and not (me and me.cancelling()):
                raise self._was_closed() from None
            raise

    async def run(self, task: Task, part: Callable[[Part], None] | None = None) -> bytes:
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
        self._stop.value = False
        running = asyncio.create_task(self._run(task, part))
        running.add_done_callback(self._end_turn)
        try:
            return await asyncio.shield(running)
        except asyncio.CancelledError:
            if not running.done():  # else it may be the turn of the next one
                self._stop.value = True
            raise

    def _end_turn(self, ended: asyncio.Task[bytes]) -> None:
        self._turn.release()
        if not ended.cancelled():
            ended.exception()  # nobody may wait for it any more

    async def _run(self, task: Task, part: Callable[[Part], None] | None) -> bytes:
        if self._stop.value:
            return b""
        with suppress(OSError):  # the answer will be missing, and that is reported
            self._pipe.send(task)
        while True:
            answer = await self._answer()
            if isinstance(answer, Part):
                if part is not None:
                    self._take(answer, part)
            elif isinstance(answer, Done):
                return answer.data
            elif isinstance(answer, Failed):
                if answer.damaged:
                    self._damaged()
                raise WorkerError(answer.error)

    def _take(self, answer: Part, part: Callable[[Part], None]) -> None:
        try:
            part(answer)
        except MotesError:  # nobody takes the rest of the answers
            self._kill()
            raise

    def close(self) -> None:
        """End the process; nobody waits for it any more."""
        self._closed = True
        self._ready.cancel()
        self._kill()

    def _kill(self) -> None:
        if not self.ended:
            self.ended = True
            self._process.kill()
            threading.Thread(target=self._process.join, daemon=True).start()

    def _was_closed(self) -> WorkerError:
        return WorkerError(f"{self._name} was closed meanwhile; open it again.")

    async def _opened(self, opening: Task) -> bytes:
        try:
            return await self._run(opening, None)
        except WorkerError:
            self._kill()
            raise

    async def _answer(self) -> Answer:
        try:
            answer = await asyncio.wait_for(self._answers.get(), self._limits.silence)
        except TimeoutError:
            self._kill()
            raise WorkerError(
                f"{self._name} kept its worker busy for {self._limits.silence:g} s without a "
                "result, so that worker was ended; convert the film."
            ) from None
        if answer is None:
            self.ended = True
            if self._closed:
                raise self._was_closed()
            await asyncio.to_thread(self._process.join, 5)
            how = cause(self._process.exitcode)
            raise WorkerError(f"{self._name} has ended its worker ({how}); convert the film.")
        return answer

    def _read(self, pipe: Connection) -> None:
        answer: Answer | None = None
        with suppress(EOFError, OSError, msgspec.MsgspecError):
            while True:
                answer = msgspec.msgpack.decode(pipe.recv_bytes(), type=Answer)
                self._put(answer)
        self._put(None)
        pipe.close()

    def _put(self, answer: Answer | None) -> None:
        with suppress(RuntimeError):  # the loop is closed: the server ends
            self._loop.call_soon_threadsafe(self._answers.put_nowait, answer)
