"""A pool without processes: each task is done here, when it is waited for."""

import os
import pickle
from collections import Counter
from collections.abc import Iterable, Mapping

import pytest

from motes_fleet.cluster import pool as pools


class InProcess:
    """A pool some of whose attempts come to nothing.

    A task gets a copy of its argument, as in another process.
    """

    def __init__(self, crashes: Iterable[str] = ()) -> None:
        self._tasks: list[pools.Task] = []
        self._crashes = Counter(crashes)
        self.done: list[str] = []

    def has_room(self, task: pools.Task) -> bool:
        """Return whether there are few."""
        return len(self._tasks) < 2

    def give(self, task: pools.Task) -> None:
        """Take a task."""
        self._tasks.append(task)

    def wait(self) -> list[pools.News]:
        """Do one."""
        task = self._tasks.pop()
        begun = pools.Started(task, "here", os.getpid())
        self.done.append(task.name)
        ended = pools.outcome(task.function, pickle.loads(pickle.dumps(task.argument)))
        if self._crashes[task.name]:  # after the work, the worst moment
            self._crashes[task.name] -= 1
            return [begun, pools.Ended(task, error="It died.", crashed=True)]
        return [begun, pools.Ended(task, *ended)]

    def show(self, numbers: Mapping[str, float]) -> None:
        """Do nothing."""

    def close(self) -> None:
        """Do nothing."""


def work_here(patch: pytest.MonkeyPatch) -> None:
    """Have tasks done in this process: others take longer to start than what they do in tests."""
    patch.setattr("motes_fleet.cluster.open_pool.LocalPool", lambda *_: InProcess())
