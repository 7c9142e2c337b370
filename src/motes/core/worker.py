"""Worker processes: the one mechanism of the studio, of batches and of the cameras of a rig.

A `Worker` is a process, seen from the program that has started it; a `WorkerLine` is its own side.
Between them are messages of bytes. What a worker sends is msgpack, which does no harm where a film
has taken the worker over. The program may send pickles, as tasks are (`do_tasks`).

A worker receives no signal that asks to end: Ctrl-C is handled by the program alone. It ends with
the program, however that ends, and all programs that the worker has started end with it.
"""

from __future__ import annotations

import atexit
import contextlib
import ctypes
import gc
import multiprocessing
import os
import pickle
import queue
import secrets
import shutil
import signal
import tempfile
import threading
import time
from collections.abc import Callable, Iterator
from multiprocessing.connection import Connection
from multiprocessing.context import BaseContext
from pathlib import Path
from typing import Any

import msgspec

from motes.core import platforms
from motes.core.callables import explain

KILLED_FIRST = "1000"
"""Score for the kernel: where memory is short, a worker dies, not the program above it."""
PATIENCE = 5.0
"""Seconds within which a process has ended that has closed its pipe."""
SIGN = 1.0
"""Seconds between the signs of life that a task gives."""
TIDY = 1.0
"""Seconds of work after which a worker gives memory back."""
STOP = b""
"""The message to a worker that its task is to end."""


THREADS = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "MOTES_THREADS")
"""Variables that limit the threads of libraries, and of motes (`motes.video.prefetch`)."""


def thread_limits(threads: int = 1) -> dict[str, str]:
    """Return the environment of a worker, with a limit for the threads of its libraries."""
    return dict.fromkeys(THREADS, str(threads))


@contextlib.contextmanager
def environment(variables: dict[str, str]) -> Iterator[None]:
    """Set variables for processes that are started meanwhile."""
    before = {name: os.environ.get(name) for name in variables}
    os.environ.update(variables)
    try:
        yield
    finally:
        for name, value in before.items():
            if value is None:
                os.environ.pop(name, None)
            else:
                os.environ[name] = value


class Part(msgspec.Struct, frozen=True, tag=True):
    """Some of the result of a task."""

    data: bytes


class Alive(msgspec.Struct, frozen=True, tag=True):
    """A task has begun, or goes on."""


class Done(msgspec.Struct, frozen=True, tag=True):
    """A task is done, or was stopped."""

    data: bytes = b""


class Failed(msgspec.Struct, frozen=True, tag=True):
    """A task has raised an error: in one line for a person, and its class."""

    error: str
    kind: str


Answer = Part | Alive | Done | Failed
"""What a worker sends that does tasks."""


class StoppedError(Exception):
    """The program wants the task to end."""


class Worker:
    """A process that calls a function with its `WorkerLine`.

    The function is at the top level of a module; it gets a line of the class `line`, and the
    arguments. By default the worker does tasks, and its process is started as a new interpreter.
    """

    def __init__(
        self,
        function: Callable[..., None] | None = None,
        *arguments: Any,
        line: type[WorkerLine] | None = None,
        context: BaseContext | None = None,
    ) -> None:
        made: Any = context or multiprocessing.get_context("spawn")
        self._scratch = os.path.join(tempfile.gettempdir(), f"motes-{secrets.token_hex(8)}")
        with platforms.blocked_signals():
            self.pipe, theirs = made.Pipe()
            given = theirs, self._scratch, line or WorkerLine, function or do_tasks, arguments
            self._process = made.Process(target=_run, args=given)
            self._process.start()
            theirs.close()
        self._ending = threading.Lock()
        atexit.register(self.end)

    @property
    def pid(self) -> int:
        """The number of the process."""
        return self._process.pid or 0

    def send(self, message: bytes) -> None:
        """Send a message; that the process has ended is noticed where it is listened to."""
        with contextlib.suppress(OSError):
            self.pipe.send_bytes(message)

    def receive(self, kind: Any = Answer) -> Any:
        """Wait for the next message; return None if none of this kind will come."""
        try:
            return msgspec.msgpack.decode(self.pipe.recv_bytes(), type=kind)
        except (EOFError, OSError, msgspec.MsgspecError):
            return None

    def give(self, task: Callable[[Any], bytes]) -> None:
        """Give a task to a worker that does tasks, and has answered the one before."""
        self.send(pickle.dumps(task))

    def stop(self) -> None:
        """Stop the task that it does; that is answered by `Done`."""
        self.send(STOP)

    def kill(self) -> None:
        """End the process and all that it has started, and do not wait for that."""
        if not self.pipe.closed:
            platforms.end_group(self.pid)
            self._process.kill()

    def cause(self) -> str:
        """Return in words how the process has ended, or soon will have."""
        self._process.join(PATIENCE)
        code = self._process.exitcode
        if code is None or code >= 0:
            return f"exit code {code}"
        name = signal.Signals(-code).name
        return f"{name} (was there too little memory?)" if name == "SIGKILL" else name

    def end(self) -> None:
        """End the process and all that it has started; its temporary files go.

        Several threads may call this, as a listener and the end of the program do.
        """
        atexit.unregister(self.end)
        with self._ending:
            self.kill()
            self._process.join()
            self.pipe.close()
            shutil.rmtree(self._scratch, ignore_errors=True)


class WorkerLine:
    """A worker's line to its program; without a program, it ends the worker.

    Messages are taken at once, so that the program never waits for a worker that is at work.
    `scratch` is the folder of temporary files, which is removed with the worker.
    """

    def __init__(self, pipe: Connection, scratch: str) -> None:
        self._pipe, self._scratch = pipe, scratch
        self._inbox: queue.SimpleQueue[bytes] = queue.SimpleQueue()
        self._sent, self._sending = 0.0, threading.Lock()
        threading.Thread(target=self._take, daemon=True).start()

    def send(self, message: msgspec.Struct) -> None:
        """Send a message; wait while the pipe is full, and raise an OSError without a receiver.

        Any thread may call this.
        """
        with self._sending:
            self._pipe.send_bytes(msgspec.msgpack.encode(message))
        self._sent = time.monotonic()

    def receive(self) -> bytes:
        """Wait for the next message."""
        return self._inbox.get()

    @property
    def waiting(self) -> bool:
        """Whether a message has come and was not received yet."""
        return not self._inbox.empty()

    def check(self) -> None:
        """Give a sign of life each second; raise `StoppedError` if the task is to end."""
        if time.monotonic() - self._sent > SIGN:
            self.send(Alive())
        if self.waiting:
            raise StoppedError

    def _take(self) -> None:
        try:
            with contextlib.suppress(EOFError, OSError):
                while True:
                    self._inbox.put(self._pipe.recv_bytes())
        finally:
            self.end()

    def end(self) -> None:
        """End the worker and all that it has started; its temporary files go."""
        shutil.rmtree(self._scratch, ignore_errors=True)
        platforms.end_group(os.getpid())
        os._exit(1)  # it may have no group of its own


def do_tasks(line: WorkerLine) -> None:
    """Do tasks as they come: functions of the line that return bytes."""
    worked = 0.0
    while True:
        message = line.receive()
        if message == STOP:
            continue  # its task was over already
        begun = time.monotonic()
        line.send(Alive())
        line.send(_answer(line, message))
        worked += time.monotonic() - begun
        if worked > TIDY:
            _give_back()
            worked = 0.0


def _answer(line: WorkerLine, message: bytes) -> Answer:
    try:
        task: Callable[[WorkerLine], bytes] = pickle.loads(message)
        return Done(task(line))
    except StoppedError:
        return Done()
    except MemoryError:
        text = "This needs more memory than a worker may have; make the film or network smaller."
        return Failed(text, MemoryError.__name__)
    except Exception as error:  # a damaged film may cause any
        return Failed(explain(error), type(error).__name__)


def _give_back() -> None:
    """Give memory that is not needed any more back to the system.

    A decoder holds its pictures in circles of references, and the C library keeps what was freed:
    without this, a worker stays as large as in its longest task, and grows.
    """
    gc.collect()
    trim = getattr(ctypes.CDLL(None), "malloc_trim", None) if os.name == "posix" else None
    if trim is not None:
        trim(0)


def _run(
    pipe: Connection, scratch: str, line: type[WorkerLine], function: Callable[..., None],
    arguments: tuple[Any, ...],
) -> None:  # fmt: skip
    """Call the function of a worker, in its process."""
    platforms.begin_group()  # with all programs that it starts
    os.dup2(2, 1)  # standard output is for results
    score = Path("/proc/self/oom_score_adj")
    if score.exists():
        score.write_text(KILLED_FIRST)
    with contextlib.suppress(OSError):  # as on a full disk, where the usual folder may do
        os.mkdir(scratch, 0o700)
        os.environ["TMPDIR"] = tempfile.tempdir = scratch
    ours = line(pipe, scratch)
    try:
        function(ours, *arguments)
    except BrokenPipeError:  # noticed here before the line has read that there is no program
        ours.end()
