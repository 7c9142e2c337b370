"""A pool of Ray's workers, on the nodes of a cluster.

A task of the pool is a task of Ray with its name and one core. It first reports where
it runs, which starts its time limit, then its result. Ray itself does not try again: attempts are
counted in one place, `pool.run`.
"""

from __future__ import annotations

import os
import socket
import time
from collections.abc import Callable, Iterator, Mapping
from typing import Any

from motes.core import interrupts
from motes_fleet.cluster import pool as pools

AHEAD = 2
"""Tasks for each core of the cluster that Ray is given at a time: no worker waits for the driver,
and the driver holds few."""
PAUSE = 5.0
"""Seconds after which the cluster is asked again for its cores: nodes come and go."""


class RayPool:
    """Workers of a cluster, to which the module `ray` is connected (`ray_connection.connected`)."""

    def __init__(self, ray: Any) -> None:
        self._ray = ray
        self._remote = ray.remote(_do)
        self._gauge: Any = None
        self._running: dict[Any, pools.Task] = {}
        self._deadlines: dict[Any, float] = {}
        self._size, self._asked = 0, -PAUSE

    def has_room(self, task: pools.Task) -> bool:
        """Return whether the cluster has few enough tasks."""
        if time.monotonic() - self._asked > PAUSE:
            nodes = [each["Resources"] for each in self._ray.nodes() if each["Alive"]]
            self._size = int(sum(node.get("CPU", 0) for node in nodes))
            self._asked = time.monotonic()
        return len(self._running) < max(AHEAD * self._size, 1)

    def give(self, task: pools.Task) -> None:
        """Give a task to the cluster."""
        options = self._remote.options(
            name=task.name, num_cpus=1, max_retries=0, num_returns="streaming"
        )
        self._running[options.remote(task.function, task.argument)] = task

    def wait(self) -> list[pools.News]:
        """Wait until a task starts or ends, or the time of a task is over."""
        if not self._running:
            return []
        timeout = min(self._deadlines.values(), default=time.monotonic() + PAUSE) - time.monotonic()
        handles = [*self._running]
        try:
            ready, _ = self._ray.wait(
                handles, num_returns=1, timeout=min(max(timeout, 0), PAUSE), fetch_local=True
            )
        except KeyboardInterrupt:
            interrupts.check()  # Ray raises one of its own, which does not know the signal
            raise
        events = [self._read(handle) for handle in ready]
        now = time.monotonic()
        for handle in [each for each, deadline in self._deadlines.items() if deadline < now]:
            task = self._forget(handle)
            self._ray.cancel(handle, force=True)
            events.append(pools.timed_out(task))
        return events

    def _read(self, handle: Any) -> pools.News:
        """Return what the next item of a task means."""
        try:
            kind, value = self._ray.get(next(handle))
        except (self._ray.exceptions.RayError, StopIteration) as error:
            # The last line of an error in a worker has its reason, the first one of all others.
            raised = isinstance(error, self._ray.exceptions.RayTaskError)
            lines = str(error).strip().splitlines() or [type(error).__name__]
            words = lines[-1 if raised else 0]
            return pools.Ended(
                self._forget(handle), error=f"Its worker ended: {words}", crashed=not raised
            )
        if kind == "started":
            task = self._running[handle]
            self._deadlines[handle] = time.monotonic() + task.seconds
            return pools.Started(task, *value)
        return pools.Ended(self._forget(handle), *value)

    def _forget(self, handle: Any) -> pools.Task:
        self._deadlines.pop(handle, None)
        return self._running.pop(handle)

    def show(self, numbers: Mapping[str, float]) -> None:
        """Set a metric of Ray, which its dashboard and Prometheus read."""
        if self._gauge is None:
            from ray.util.metrics import Gauge

            self._gauge = Gauge("motes_batch_jobs", "Jobs of the batch.", ("status",))
        for status, number in numbers.items():
            self._gauge.set(number, {"status": status})

    def close(self) -> None:
        """Stop all tasks."""
        for handle in self._running:
            self._ray.cancel(handle, force=True)
        self._running.clear()
        self._deadlines.clear()


def _do(function: Callable[[Any], Any], argument: Any) -> Iterator[tuple[str, Any]]:
    """Report where this runs, then the result."""
    yield "started", (socket.gethostname(), os.getpid())
    yield "ended", pools.outcome(function, argument)
