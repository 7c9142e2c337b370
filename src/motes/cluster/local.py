"""A pool of processes of this machine, which may hang, crash and be stopped.

Each worker has a process group of its own, with all programs that its task starts. It receives no
signal that asks to end: Ctrl-C is handled by the main program alone. It ends with that program,
however that ends.
"""

from __future__ import annotations

import contextlib
import math
import multiprocessing
import os
import shutil
import socket
import tempfile
import threading
import time
from collections.abc import Mapping
from multiprocessing.connection import Connection, wait
from pathlib import Path
from typing import Any, Self

from motes.cluster.pool import Ended, Event, Started, Task, ended, outcome, timed_out
from motes.cluster.resources import environment, thread_limits
from motes.core.system import system
from motes.core.worker_processes import blocked_signals, cause, started

LONGEST_WAIT = 3600.0
"""Seconds; operating systems limit how long a process can wait at once."""
KILLED_FIRST = "1000"
"""Score for the kernel: where memory is short, a worker dies, not the program above it."""


class LocalPool:
    """Processes of this machine.

    Parameters
    ----------
    workers
        Number of tasks that run at the same time.
    memory
        Bytes that these tasks may need in all, as far as they are known; None for no limit. A task
        that needs more than that runs alone.
    threads
        Threads that libraries may start in a worker; None leaves that to them.
    """

    def __init__(self, workers: int, memory: int | None = None, threads: int | None = None) -> None:
        self._workers, self._memory = workers, memory
        self._variables = {} if threads is None else thread_limits(threads)
        self._idle: list[_Worker] = []
        self._busy: list[_Worker] = []
        # The temporary files of all workers are here, so that those of stopped ones go too.
        self._scratch = tempfile.TemporaryDirectory(prefix="motes-")

    def has_room(self, task: Task) -> bool:
        """Return whether a worker is free, and the memory that the task needs."""
        if not self._busy or self._memory is None:
            return len(self._busy) < self._workers
        needed = sum(worker.task.memory for worker in self._busy) + task.memory
        return len(self._busy) < self._workers and needed <= self._memory

    def give(self, task: Task) -> None:
        """Give a task to a worker."""
        if self._idle:
            worker = self._idle.pop()
        else:
            with environment(self._variables):
                worker = _Worker(self._scratch.name)
        self._busy.append(worker)
        worker.assign(task)

    def wait(self) -> list[Event]:
        """Wait until a task starts or ends, or a worker dies, or the time of a task is over."""
        if not self._busy:
            return []
        timeout = min(worker.deadline for worker in self._busy) - time.monotonic()
        handles = [handle for worker in self._busy for handle in worker.handles]
        wait(handles, min(max(timeout, 0), LONGEST_WAIT))
        events = [event for worker in self._busy for event in worker.poll()]
        for worker in [worker for worker in self._busy if worker.done]:
            self._busy.remove(worker)
            if worker.alive:
                self._idle.append(worker)
        return events

    def show(self, numbers: Mapping[str, float]) -> None:
        """Do nothing: there is no page."""

    def close(self) -> None:
        """End all workers."""
        with blocked_signals():
            for worker in (*self._idle, *self._busy):
                worker.end()
            self._scratch.cleanup()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()


class _Worker:
    """A process that runs one task after another."""

    task: Task

    def __init__(self, scratch: str) -> None:
        # A task may start processes itself.
        self._process, self._pipe = started(_serve, scratch, daemon=False)
        self.alive, self.done = True, True
        self.deadline = math.inf

    @property
    def handles(self) -> tuple[Any, ...]:
        """Handles that become ready when `poll` has something to read."""
        return self._pipe, self._process.sentinel

    def assign(self, task: Task) -> None:
        """Give the worker a task."""
        self.task, self.deadline, self.done = task, math.inf, False
        with contextlib.suppress(OSError):  # `poll` will notice if the process is dead
            self._pipe.send((task.function, task.argument))

    def poll(self) -> list[Event]:
        """Return what has happened since the last time."""
        events, running = list[Event](), self._process.is_alive()
        with contextlib.suppress(EOFError, OSError):
            while not self.done and self._pipe.poll():
                events.append(self._read(*self._pipe.recv()))
        if self.done or (running and time.monotonic() < self.deadline):
            return events
        self.end()
        if running:
            return [*events, timed_out(self.task)]
        error = f"Its process ended with {cause(self._process.exitcode)}."
        return [*events, Ended(self.task, error=error, crashed=True)]

    def _read(self, kind: str, value: Any) -> Event:
        """Return what a message of the process means."""
        if kind == "started":
            self.deadline = time.monotonic() + self.task.seconds
            return Started(self.task, *value)
        self.done = True
        return ended(self.task, kind, value)

    def end(self) -> None:
        """End the process and all processes that it started."""
        self.alive, self.done = False, True
        if self._process.pid is not None:
            system.end_group(self._process.pid)
        self._process.kill()
        self._process.join()
        self._pipe.close()


# The functions below run in a worker.


def _serve(pipe: Connection, scratch: str) -> None:
    """Run tasks as they arrive."""
    system.begin_group()  # with all programs that tasks start
    os.dup2(2, 1)  # standard output is for results
    os.environ["TMPDIR"] = tempfile.tempdir = scratch
    score = Path("/proc/self/oom_score_adj")
    if score.exists():
        score.write_text(KILLED_FIRST)
    parent = multiprocessing.parent_process()
    assert parent is not None
    threading.Thread(target=_end_with_parent, args=(parent.sentinel, scratch), daemon=True).start()
    me = socket.gethostname(), os.getpid()
    with contextlib.suppress(EOFError):
        while True:
            function, argument = pipe.recv()
            pipe.send(("started", me))
            pipe.send(outcome(function, argument))


def _end_with_parent(sentinel: int, scratch: str) -> None:
    """End this process group when the main program ends, and remove its files."""
    wait([sentinel])
    shutil.rmtree(scratch, ignore_errors=True)
    system.end_group(os.getpid())
