"""Pools of workers: tasks go in, their starts and ends come out, whatever dies.

A `Pool` has two implementations: the processes of this machine (`local_pool.py`) and tasks of Ray
(`on_ray.py`). `run` is the loop above both. It takes tasks one by one, as there is room for them,
so that the number of those that wait does not matter.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Generator, Iterable, Mapping
from dataclasses import dataclass, replace
from typing import Any, NamedTuple, Protocol

from motes.core import explain

TIME_LIMIT = 1800.0
"""Seconds for a task, by default."""
ATTEMPTS = 3
"""How often a task may end its worker, by default, before it counts as failed."""


class TryAgain(Exception):  # noqa: N818
    """Raised by a task whose failure is not its own, as of a network: it may be tried again."""


@dataclass(frozen=True, slots=True, eq=False)
class Task:
    """A call that any worker can make."""

    name: str
    """Its name in messages."""
    function: Callable[[Any], Any]
    """A function at the top level of a module."""
    argument: Any
    """Its argument; it is sent to the worker, and the result back."""
    seconds: float = TIME_LIMIT
    """Its time limit."""
    attempt: int = 1
    """The number of this attempt, from 1."""


class Started(NamedTuple):
    """A task has begun: its host and its process."""

    task: Task
    host: str
    pid: int


class Ended(NamedTuple):
    """A task has ended."""

    task: Task
    """The task."""
    value: Any = None
    """The result of its function; None if there is none."""
    error: str | None = None
    """Why there is no result, in one line."""
    crashed: bool = False
    """Whether the worker died, for whatever reason but the time limit, or the task asks for it:
    another attempt may succeed."""


class Again(NamedTuple):
    """An attempt has ended without a result, and there will be another one."""

    task: Task
    error: str


News = Started | Ended


def outcome(function: Callable[[Any], Any], argument: Any) -> tuple[Any, str | None, bool]:
    """Call a function in a worker; return what `Ended` has beside the task."""
    try:
        return function(argument), None, False
    except TryAgain as error:
        return None, str(error), True
    except BaseException as error:  # a task may raise anything
        return None, explain(error), False


def timed_out(task: Task) -> Ended:
    """Return the end of a task that was stopped at its time limit; it is not tried again."""
    return Ended(
        task,
        error=f"It took longer than the {task.seconds:g} s that each job has, and was stopped.",
    )


class Pool(Protocol):
    """Workers that run one task each at a time; it is closed at the end."""

    def has_room(self, task: Task) -> bool:
        """Return whether a task can be given now."""
        ...

    def give(self, task: Task) -> None:
        """Give a task to the workers."""
        ...

    def wait(self) -> list[News]:
        """Wait until something has happened, for some seconds at most."""
        ...

    def show(self, numbers: Mapping[str, float]) -> None:
        """Show the number of jobs of each status, where the pool has a page for that."""
        ...

    def close(self) -> None:
        """End all workers, with the tasks that they run."""
        ...


def run(
    pool: Pool, tasks: Iterable[Task], attempts: int = 1
) -> Generator[News | Again, None, None]:
    """Run tasks; yield the start and the end of each attempt, and the end of each task.

    A task is taken when the one before it has found a worker. Each is given to workers as often as
    `attempts`, if these die. The caller closes the pool.
    """
    waiting, again = iter(tasks), deque[Task]()
    following, running = next(waiting, None), 0
    while following is not None or again or running:
        while (task := again[0] if again else following) is not None and pool.has_room(task):
            if again:
                again.popleft()
            else:
                following = next(waiting, None)
            pool.give(task)
            running += 1
        for event in pool.wait():
            if isinstance(event, Ended):
                running -= 1
                if event.crashed and event.task.attempt < attempts:
                    again.append(replace(event.task, attempt=event.task.attempt + 1))
                    yield Again(event.task, event.error or "")
                    continue
            yield event
