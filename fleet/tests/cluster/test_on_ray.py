"""The same jobs on Ray: same results, whatever dies."""

import os
import signal
from contextlib import closing
from pathlib import Path
from typing import Any

import pytest

import batch_jobs
from motes import ConfigError
from motes.cli import main
from motes_fleet.cluster import pool as pools
from motes_fleet.cluster.driver import batch
from motes_fleet.cluster.jobs import Job
from motes_fleet.cluster.local_pool import LocalPool
from motes_fleet.cluster.on_ray import RayPool
from motes_fleet.cluster.ray_connection import connected
from motes_fleet.cluster.records import Record
from motes_fleet.cluster.store import Folder
from motes_fleet.cluster.work import Plan

pytestmark = [
    pytest.mark.slow,
    pytest.mark.filterwarnings("ignore"),  # those of Ray
]


def results(out: Path) -> dict[str, bytes]:
    return {str(p.relative_to(out)): p.read_bytes() for p in out.glob("rows/**/*") if p.is_file()}


def test_workers_die_hang_and_go_on(cluster: Any, tmp_path: Path) -> None:
    given = [
        pools.Task("dies", batch_jobs.die, None),
        pools.Task("dies once", batch_jobs.die_first, str(tmp_path / "marker")),
        pools.Task("hangs", batch_jobs.hang, None, seconds=0.5),
        pools.Task("raises", batch_jobs.raise_error, "no"),
        pools.Task("square", batch_jobs.square, 3),
    ]
    with connected(cluster.address) as ray:
        pool = RayPool(ray)
        events = list(pools.run(pool, given, attempts=2))
        pool.close()
    ended = {each.task.name: each for each in events if isinstance(each, pools.Ended)}
    assert ended["dies"].crashed
    assert ended["dies once"].value == "alive"
    assert "longer than the 0.5 s" in str(ended["hangs"].error)
    assert ended["raises"].error == "ValueError: no"
    assert ended["square"].value == 9


def test_the_commands_on_a_cluster(
    cluster: Any, tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: Any
) -> None:
    monkeypatch.chdir(tmp_path)
    batch_jobs.films(tmp_path, 2)
    words = "batch film-*.mp4 --init 2,2,16,12 --preset mean_shift"
    assert main([*words.split(), "-o", "out", "--cluster", cluster.address]) == 0
    assert "2 jobs, 2 done, 0 failed, 25 frames" in capsys.readouterr().err
    assert main(["track", "film-1.mp4", "--init", batch_jobs.REGION, "--preset", "mean_shift",
                 "-o", "rows.csv"]) == 0  # fmt: skip
    assert results(Path("out"))["rows/job=film-1/rows.csv"] == Path("rows.csv").read_bytes()


def test_rows_are_those_of_one_process(cluster: Any, tmp_path: Path) -> None:
    """A worker and a node are killed meanwhile."""
    node = cluster.add_node(num_cpus=1)
    films = batch_jobs.films(tmp_path)
    jobs = [
        Job(name=f"j{n}", source=str(films[n % 3]), init=((2, 2, 16, 12),), seed=n)
        for n in range(6)
    ]
    from motes_fleet.commands.batch_job import make

    def done(pool: Any, out: Path, hit: bool) -> list[Any]:
        plan, events = Plan(str(out), make, attempts=9), []
        for event in batch(pool, Folder(out), jobs, plan, lambda _: None):
            events.append(event)
            count = sum(isinstance(each, pools.Started) for each in events)
            if hit and isinstance(event, pools.Started) and count == 1:
                os.kill(event.pid, signal.SIGKILL)
            elif hit and isinstance(event, pools.Started) and count == 3:
                cluster.remove_node(node, allow_graceful=False)
        return events

    with closing(LocalPool(1)) as local:
        done(local, tmp_path / "local", hit=False)
    with connected(cluster.address) as ray:
        pool = RayPool(ray)
        events = done(pool, tmp_path / "ray", hit=True)
        pool.close()
    assert any(isinstance(each, pools.Again) for each in events)
    finished = [each for each in events if isinstance(each, Record)]
    assert sorted(each.name for each in finished) == sorted(job.name for job in jobs)
    assert results(tmp_path / "ray") == results(tmp_path / "local")


def test_a_cluster_that_is_not_there(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    pytest.importorskip("ray")
    monkeypatch.delenv("RAY_ADDRESS", raising=False)
    monkeypatch.setattr("motes_fleet.cluster.ray_connection.CURRENT", tmp_path / "none")
    with pytest.raises(ConfigError, match="no cluster runs on this machine"), connected("auto"):
        pass
    monkeypatch.setenv("RAY_ADDRESS", "127.0.0.1:9")
    with pytest.raises(ConfigError, match=r"127\.0\.0\.1:9: Connection refused"), connected("auto"):
        pass
