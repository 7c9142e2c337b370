"""Pools: what dies is tried again, what hangs is stopped, and workers go on."""

from collections import Counter
from collections.abc import Mapping
from contextlib import closing
from pathlib import Path

import pytest

import batch_jobs
from motes_fleet.cluster import machine, pool as pools
from motes_fleet.cluster.local_pool import LocalPool


class Script:
    """A pool in which the attempts of each task end as a script says."""

    def __init__(self, room: int, ends: dict[str, list[bool]]) -> None:
        self._room, self._ends = room, ends
        self.running: list[pools.Task] = []
        self.most = 0

    def has_room(self, task: pools.Task) -> bool:
        """Return whether there are few."""
        return len(self.running) < self._room

    def give(self, task: pools.Task) -> None:
        """Take a task."""
        self.running.append(task)
        self.most = max(self.most, len(self.running))

    def wait(self) -> list[pools.News]:
        """Do one."""
        task = self.running.pop(0)
        crashed = self._ends[task.name].pop(0)
        return [pools.Ended(task, None if crashed else task.argument, crashed=crashed)]

    def show(self, numbers: Mapping[str, float]) -> None:
        """Do nothing."""

    def close(self) -> None:
        """Do nothing."""


def tasks(names: str) -> list[pools.Task]:
    return [pools.Task(name, batch_jobs.square, name) for name in names]


def test_a_task_is_tried_until_its_attempts_are_used_up() -> None:
    pool = Script(2, {"a": [False], "b": [True, True, True], "c": [True, False]})
    events = list(pools.run(pool, tasks("abc"), attempts=3))
    assert Counter(each.task.name for each in events if isinstance(each, pools.Again)) == {
        "b": 2,
        "c": 1,
    }
    ended = {each.task.name: each for each in events if isinstance(each, pools.Ended)}
    assert [ended[name].crashed for name in "abc"] == [False, True, False]
    assert [ended[name].task.attempt for name in "abc"] == [1, 3, 2]
    assert pool.most == 2


def test_tasks_are_taken_as_there_is_room() -> None:
    pool, taken = Script(3, {str(n): [False] for n in range(1000)}), 0

    def all_() -> object:
        nonlocal taken
        for n in range(1000):
            taken += 1
            yield pools.Task(str(n), batch_jobs.square, n)

    for ended, _ in enumerate(pools.run(pool, all_()), 1):  # type: ignore[arg-type]
        assert taken <= ended + 4
    assert taken == 1000


def test_a_task_may_ask_for_another_attempt() -> None:
    def lost(_: object) -> None:
        raise pools.TryAgain("the network")

    assert pools.outcome(lost, None) == (None, "the network", True)
    assert pools.outcome(batch_jobs.raise_error, "no") == (None, "ValueError: no", False)
    assert pools.outcome(batch_jobs.square, 3) == (9, None, False)


@pytest.mark.slow
def test_workers_die_hang_and_go_on(tmp_path: Path) -> None:
    given = [
        pools.Task("dies", batch_jobs.die, None),
        pools.Task("dies once", batch_jobs.die_first, str(tmp_path / "marker")),
        pools.Task("hangs", batch_jobs.hang, None, seconds=0.5),
        pools.Task("raises", batch_jobs.raise_error, "no"),
        *(pools.Task(f"{n}", batch_jobs.square, n) for n in range(4)),
    ]
    with closing(LocalPool(2)) as pool:
        events = list(pools.run(pool, given, attempts=2))
    ended = {each.task.name: each for each in events if isinstance(each, pools.Ended)}
    assert ended["dies"].crashed
    assert "SIGKILL (was there too little memory?)" in str(ended["dies"].error)
    assert ended["dies once"].value == "alive"
    assert "longer than the 0.5 s" in str(ended["hangs"].error)
    assert ended["raises"].error == "ValueError: no"
    assert [ended[f"{n}"].value for n in range(4)] == [0, 1, 4, 9]
    pids = [each.pid for each in events if isinstance(each, pools.Started)]
    assert len(set(pids)) < len(pids)  # a worker does one task after another


@pytest.mark.parametrize(
    ("files", "cores"),
    [
        ({"cpu.max": "max 100000"}, 64),
        ({"cpu.max": "250000 100000"}, 2),
        ({"cpu.max": "50000 100000"}, 1),
        ({"cpu/cpu.cfs_quota_us": "-1", "cpu/cpu.cfs_period_us": "100000"}, 64),
        ({"cpu/cpu.cfs_quota_us": "300000", "cpu/cpu.cfs_period_us": "100000"}, 3),
        ({}, 64),
    ],
)
def test_cores_of_a_container(
    tmp_path: Path, files: dict[str, str], cores: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("os.sched_getaffinity", lambda _: range(64))
    for name, text in files.items():
        (tmp_path / name).parent.mkdir(exist_ok=True)
        (tmp_path / name).write_text(text + "\n")
    assert machine.cores(tmp_path) == cores
