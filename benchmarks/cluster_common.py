"""What the measurements of `motes batch` share: films, tables of jobs, results to compare."""

from __future__ import annotations

import contextlib
import csv
import os
import subprocess
import sys
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

from motes import synthetic
from motes.video.writer import VideoWriter

PROGRAM = [sys.executable, "-m", "motes", "batch"]
BOX = "20,50,30,24"
SIZE = (160, 120)


def film(path: Path, frames: int) -> Path:
    """Render a film in which a target that begins at `BOX` crosses the picture."""
    if not path.exists():
        with VideoWriter(path, 25) as writer:
            for frame, _ in synthetic.crossing(SIZE, frames):
                writer.write(frame.pixels)
    return path


def table(path: Path, films: Sequence[Path], jobs: int, preset: str = "nummiaro") -> Path:
    """Write a table of jobs, each with a film and a seed of its own."""
    with path.open("w", newline="") as file:
        writer = csv.writer(file)
        writer.writerow(["name", "source", "do", "init", "preset", "seed"])
        for job in range(jobs):
            source = films[job % len(films)]
            writer.writerow([f"job-{job}", source, "track", BOX, preset, job])
    return path


def start(
    jobs: Path,
    out: str | Path,
    *options: str,
    cores: int | None = None,
    variables: Mapping[str, str] | None = None,
) -> subprocess.Popen[bytes]:
    """Start a batch, on some of the machine's cores only if their number is given."""
    allowed = sorted(os.sched_getaffinity(0))[:cores]
    with (jobs.parent / "errors").open("ab") as errors:
        return subprocess.Popen(
            [*PROGRAM, str(jobs), "-o", str(out), *options],
            stdout=subprocess.DEVNULL,
            stderr=errors,
            env=os.environ | dict(variables or {}),
            preexec_fn=lambda: os.sched_setaffinity(0, allowed),
        )


def finish(jobs: Path, out: str | Path, *options: str, cores: int | None = None) -> None:
    """Run a batch to its end; raise a RuntimeError if it fails."""
    if start(jobs, out, *options, cores=cores).wait() != 0:
        raise RuntimeError((jobs.parent / "errors").read_text()[-2000:])


def running(driver: int) -> list[int]:
    """Return the processes that do jobs: workers of the driver, and tasks of Ray by their names."""
    found = []
    for process in Path("/proc").glob("[0-9]*"):
        with contextlib.suppress(OSError):  # it has ended
            line = (process / "cmdline").read_text()
            parent = int((process / "stat").read_text().rpartition(")")[2].split()[1])
            worker = parent == driver and "multiprocessing.spawn" in line
            if worker or line.startswith("ray::job-"):
                found.append(int(process.name))
    return found


def results(out: Path) -> dict[str, bytes]:
    """Return the results in a folder, by their names."""
    return {
        str(path.relative_to(out)): path.read_bytes()
        for path in sorted((out / "rows").rglob("*"))
        if path.is_file()
    }


def stamps(out: Path) -> dict[str, int]:
    """Return when each record was written: a job that is done again has another time."""
    return {path.name: path.stat().st_mtime_ns for path in (out / "jobs").glob("*.json")}


@contextlib.contextmanager
def ray_cluster(nodes: int, cores: int = 1) -> Iterator[Any]:
    """Give a cluster on this machine, whose head does not work, with so many other nodes."""
    from ray.cluster_utils import Cluster

    head = {"num_cpus": 0, "include_dashboard": False}
    cluster = Cluster(initialize_head=True, head_node_args=head)
    try:
        for _ in range(nodes):
            cluster.add_node(num_cpus=cores, wait=True)
        yield cluster
    finally:
        cluster.shutdown()
