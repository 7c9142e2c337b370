"""A pool of processes of this machine, which may hang, crash and be stopped."""

from __future__ import annotations

import math
import pickle
import socket
import time
from collections.abc import Callable, Mapping
from functools import partial
from multiprocessing.connection import Connection, wait
from typing import Any

from motes.core import Done, Failed, Worker, blocked_signals, environment, thread_limits
from motes_fleet.cluster.pool import Ended, News, Started, Task, outcome, timed_out

LONGEST_WAIT = 3600.0
"""Seconds; operating systems limit how long a process can wait at once."""


class TaskWorker(Worker):
    """A worker with the task that it does, and the time at which that must be done."""

    task: Task
    deadline: float


class LocalPool:
    """Processes of this machine.

    Parameters
    ----------
    workers
        Number of tasks that run at the same time.
    threads
        Threads that libraries may start in a worker; None leaves that to them.
    """

    def __init__(self, workers: int, threads: int | None = None) -> None:
        self._workers = workers
        self._variables = {} if threads is None else thread_limits(threads)
        self._idle: list[TaskWorker] = []
        self._busy: dict[Connection, TaskWorker] = {}

    def has_room(self, task: Task) -> bool:
        """Return whether a worker is free."""
        return len(self._busy) < self._workers

    def give(self, task: Task) -> None:
        """Give a task to a worker."""
        if self._idle:
            worker = self._idle.pop()
        else:
            with environment(self._variables):
                worker = TaskWorker()
        worker.task, worker.deadline = task, math.inf
        self._busy[worker.pipe] = worker
        worker.give(partial(_outcome, function=task.function, argument=task.argument))

    def wait(self) -> list[News]:
        """Wait until a task starts or ends, or a worker dies, or the time of a task is over."""
        if not self._busy:
            return []
        timeout = min(worker.deadline for worker in self._busy.values()) - time.monotonic()
        ready = wait([*self._busy], min(max(timeout, 0), LONGEST_WAIT))
        events = [self._read(worker) for pipe, worker in [*self._busy.items()] if pipe in ready]
        now = time.monotonic()
        for worker in [worker for worker in self._busy.values() if worker.deadline <= now]:
            self._end(worker)
            events.append(timed_out(worker.task))
        return events

    def _read(self, worker: TaskWorker) -> News:
        """Return what the next answer of a worker means, or its end."""
        task = worker.task
        answer = worker.receive()
        if answer is None:
            cause = worker.cause()
            self._end(worker)
            return Ended(task, error=f"Its process ended with {cause}.", crashed=True)
        if not isinstance(answer, Done | Failed):  # it has begun
            worker.deadline = time.monotonic() + task.seconds
            return Started(task, socket.gethostname(), worker.pid)
        self._idle.append(self._busy.pop(worker.pipe))
        if isinstance(answer, Failed):  # as of a result that cannot be sent
            return Ended(task, error=answer.error)
        return Ended(task, *pickle.loads(answer.data))

    def _end(self, worker: TaskWorker) -> None:
        del self._busy[worker.pipe]
        worker.end()

    def show(self, numbers: Mapping[str, float]) -> None:
        """Do nothing: there is no page."""

    def close(self) -> None:
        """End all workers."""
        with blocked_signals():
            for worker in (*self._idle, *self._busy.values()):
                worker.end()


def _outcome(_: object, function: Callable[[Any], Any], argument: Any) -> bytes:
    """Call a function in a worker."""
    return pickle.dumps(outcome(function, argument))
