"""How fast `motes batch` is: workers, overhead, memory of the driver, growth.

    python benchmarks/cluster_speed.py workers           one worker, two, and two on Ray; 24 films
    python benchmarks/cluster_speed.py overhead          2,000 jobs of 10 frames
    python benchmarks/cluster_speed.py overhead --ray    the same on Ray
    python benchmarks/cluster_speed.py tasks             empty tasks, local and on Ray
    python benchmarks/cluster_speed.py memory            the driver's, with 100,000 jobs that wait
    python benchmarks/cluster_speed.py growth --plot growth.png

Rounds are interleaved, so that a busy machine hits all sides. Processor time is that of the driver
and of its processes; it is steadier than the clock, but those of Ray are no children of the driver.
"""

from __future__ import annotations

import argparse
import contextlib
import math
import resource
import signal
import statistics
import sys
import tempfile
import time
from collections.abc import Iterator, Sequence
from pathlib import Path

from cluster_common import film, finish, ray_cluster, results, start, table
from motes_fleet.cluster.local_pool import LocalPool
from motes_fleet.cluster.on_ray import RayPool
from motes_fleet.cluster.pool import Pool, Task, run
from motes_fleet.cluster.ray_connection import connected
from motes_fleet.cluster.table import JobTable
from motes_fleet.commands.batch_job import make
from motes_lab.report import markdown
from motes_lab.report.tables import Cell, Row, Table


def said(what: str, measured: str) -> Row:
    """Return a row of the table."""
    return Cell(what), Cell(measured)


def clocked(jobs: Path, out: Path, *options: str, cores: int | None = None) -> tuple[float, float]:
    """Return the seconds and the processor seconds of a batch."""
    before, begun = resource.getrusage(resource.RUSAGE_CHILDREN), time.perf_counter()
    finish(jobs, out, *options, cores=cores)
    after, seconds = resource.getrusage(resource.RUSAGE_CHILDREN), time.perf_counter() - begun
    used = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
    return seconds, used


def own_work(jobs: Path, folder: Path) -> tuple[float, float]:
    """Return the seconds and the processor seconds of the jobs alone, in this process."""
    seconds, used = 0.0, 0.0
    for number, job in enumerate(JobTable(str(jobs)).jobs()):
        goal = folder / str(number)
        goal.mkdir(parents=True)
        begun, before = time.perf_counter(), time.process_time()
        make(job, goal, "csv", overlay=False)
        seconds += time.perf_counter() - begun
        used += time.process_time() - before
    return seconds, used


def startup(jobs: Path, folder: Path, options: Sequence[str]) -> tuple[float, float]:
    """Return the seconds and the processor seconds of a batch of one job."""
    text = jobs.read_text().splitlines(keepends=True)
    one = folder / "one.csv"
    one.write_text("".join(text[:2]))
    return clocked(one, Path(tempfile.mkdtemp(dir=folder)) / "out", *options)


def compare_workers(folder: Path, rounds: int, preset: str, longer: int) -> Iterator[Row]:
    """Yield the ratios of one worker to two, and of the local pool to Ray.

    A worker whose film is decoded by a thread uses more than one core where it has them. So there
    are two baselines: one worker on one core, and one worker on the whole machine.
    """
    films = [film(folder / f"{n}.mp4", longer * (60 + 45 * n)) for n in range(24)]
    jobs = table(folder / "jobs.csv", films, 24, preset)
    with ray_cluster(2) as cluster:
        sides: dict[str, tuple[tuple[str, ...], int | None]] = {
            "one worker, one core": (("--workers", "1"), 1),
            "one worker": (("--workers", "1"), None),
            "two workers": (("--workers", "2"), None),
            "Ray": (("--cluster", cluster.address), None),
        }
        taken: dict[str, list[float]] = {name: [] for name in sides}
        for number in range(rounds):
            for name, (options, cores) in sides.items():
                seconds, used = clocked(jobs, folder / f"{name}-{number}", *options, cores=cores)
                taken[name].append(seconds)
                print(f"{name}: {seconds:.1f} s, {used:.1f} s of processors", file=sys.stderr)
        assert results(folder / "one worker-0") == results(folder / "Ray-0")
    for slow, fast in (
        ("one worker, one core", "two workers"),
        ("one worker", "two workers"),
        ("two workers", "Ray"),
    ):
        ratios = [a / b for a, b in zip(taken[slow], taken[fast], strict=True)]
        yield said(
            f"{fast} against {slow}, {preset}",
            f"{statistics.median(ratios):.2f} times as fast ({min(ratios):.2f} to "
            f"{max(ratios):.2f}, {rounds} rounds), {statistics.median(taken[fast]):.1f} s",
        )


def overhead(folder: Path, count: int, workers: int, ray: bool) -> Iterator[Row]:
    """Yield what a job costs beyond its own work."""
    jobs = table(folder / "jobs.csv", [film(folder / "film.mp4", 10)], count)
    with contextlib.ExitStack() as stack:
        options: tuple[str, ...] = ("--workers", str(workers))
        if ray:
            options = ("--cluster", stack.enter_context(ray_cluster(workers)).address)
        alone = startup(jobs, folder, options)
        whole = clocked(jobs, folder / "out", *options)
        own = own_work(jobs, folder / "own")
    ms = 1000 / count
    wall = (whole[0] - alone[0]) * workers - own[0]
    used = (whole[1] - alone[1] - own[1]) * ms
    yield said(
        f"overhead of each of {count:,} jobs, {workers} workers{' of Ray' if ray else ''}",
        f"{wall * ms:.1f} ms by the clock" + ("" if ray else f", {used:.1f} ms of the processor"),
    )


def tasks(count: int) -> Iterator[Row]:
    """Yield how long the driver has for a task that does nothing, after some that warm it up."""
    with (
        contextlib.closing(LocalPool(2)) as local,
        ray_cluster(2) as cluster,
        connected(cluster.address) as ray,
    ):
        remote = RayPool(ray)
        pools: dict[str, Pool] = {"local": local, "Ray": remote}
        rows: dict[str, Row] = {}
        for name, pool in (*pools.items(), *pools.items()):  # the second turn counts
            begun, before = time.perf_counter(), time.process_time()
            for _ in run(pool, (Task(f"{n}", abs, n) for n in range(count))):
                pass
            wall, used = time.perf_counter() - begun, time.process_time() - before
            ms = 1000 / count
            rows[name] = said(
                f"an empty task, {name}",
                f"{wall * ms:.1f} ms by the clock, {used * ms:.2f} ms of the driver's processor",
            )
        remote.close()
    yield from rows.values()


def memory(folder: Path, counts: Sequence[int], seconds: float) -> Iterator[Row]:
    """Yield the largest memory of the driver while so many jobs wait."""
    source = film(folder / "film.mp4", 200)
    for count in counts:
        jobs, out = table(folder / f"{count}.csv", [source], count), folder / f"out-{count}"
        process, sizes = start(jobs, out, "--workers", "1"), list[int]()
        while not list((out / "jobs").glob("*.json")) and process.poll() is None:
            time.sleep(0.2)
        end = time.monotonic() + seconds
        while time.monotonic() < end and process.poll() is None:
            lines = Path(f"/proc/{process.pid}/status").read_text().splitlines()
            known = dict(line.split(":", 1) for line in lines)
            sizes.append(int(known["VmRSS"].split()[0]) >> 10)
            peak = int(known["VmHWM"].split()[0]) >> 10
            time.sleep(0.5)
        process.send_signal(signal.SIGTERM)
        begun = time.monotonic()
        process.wait()
        yield said(
            f"the driver, {count:,} jobs that wait",
            f"{sizes[0]} MB at first, {sizes[-1]} MB after {seconds:.0f} s, {peak} MB at most; "
            f"ends {time.monotonic() - begun:.1f} s after SIGTERM",
        )


def power(sizes: Sequence[float], values: Sequence[float]) -> float:
    """Return the exponent of a power law, by least squares of logarithms."""
    x, y = ([math.log(value) for value in each] for each in (sizes, values))
    mx, my = statistics.mean(x), statistics.mean(y)
    return sum((a - mx) * (b - my) for a, b in zip(x, y, strict=True)) / sum(
        (a - mx) ** 2 for a in x
    )


def growth(
    folder: Path,
    plot: Path | None,
    counts: Sequence[int],
    workers: Sequence[int],
    preset: str,
    longer: int,
) -> Iterator[Row]:
    """Yield how the time grows with jobs and workers, with the power; draw it.

    So many workers have as many cores.
    """
    source = film(folder / "film.mp4", 10)
    by_jobs = []
    for count in counts:
        jobs = table(folder / f"{count}.csv", [source], count)
        by_jobs.append(clocked(jobs, folder / f"jobs-{count}", "--workers", "2")[1])
        yield said(f"{count:,} jobs of 10 frames", f"{by_jobs[-1]:.1f} s of the processor")
    films = [film(folder / f"{n}.mp4", longer * (60 + 45 * n)) for n in range(12)]
    jobs = table(folder / "jobs.csv", films, 12, preset)
    by_workers = []
    for number in workers:
        out = folder / f"w-{number}"
        by_workers.append(clocked(jobs, out, "--workers", str(number), cores=number)[0])
        yield said(f"12 films, {number} workers", f"{by_workers[-1]:.1f} s by the clock")
    powers = power(counts, by_jobs), power(workers, by_workers)
    yield said("growth with jobs, with workers, as a power", f"{powers[0]:.2f}, {powers[1]:.2f}")
    if plot is None:
        return
    from matplotlib.figure import Figure

    figure = Figure(figsize=(8, 3.2), layout="constrained")
    for axes, sizes, values, exponent, names in zip(
        figure.subplots(1, 2),
        (counts, workers),
        (by_jobs, by_workers),
        powers,
        (("jobs of 10 frames", "processor time, s"), ("workers", "time of 12 films, s")),
        strict=True,
    ):
        axes.loglog(sizes, values, "o-")
        axes.set_xticks(sizes, [f"{size:,}" for size in sizes])
        axes.set_yticks(values, [f"{value:.1f}" for value in values])
        axes.minorticks_off()
        axes.set(xlabel=names[0], ylabel=names[1], title=f"power {exponent:.2f}")
    figure.savefig(plot, metadata={"Date": None})


def main() -> int:
    """Measure one of these."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("what", choices=["workers", "overhead", "tasks", "memory", "growth"])
    parser.add_argument("--ray", action="store_true")
    parser.add_argument("--rounds", type=int, default=3)
    parser.add_argument("--preset", default="nummiaro", help="of the films that workers share")
    parser.add_argument("--longer", type=int, default=1, help="how much longer these films are")
    parser.add_argument("--jobs", type=int, nargs="+", help="their number, or their numbers")
    parser.add_argument("--workers", type=int, nargs="+", default=[2])
    parser.add_argument("--seconds", type=float, default=60.0)
    parser.add_argument("--plot", type=Path)
    options = parser.parse_args()
    with tempfile.TemporaryDirectory(prefix="speed-") as scratch:
        folder = Path(scratch)
        if options.what == "workers":
            rows = compare_workers(folder, options.rounds, options.preset, options.longer)
        elif options.what == "overhead":
            rows = overhead(folder, (options.jobs or [2000])[0], options.workers[0], options.ray)
        elif options.what == "tasks":
            rows = tasks((options.jobs or [500])[0])
        elif options.what == "memory":
            rows = memory(folder, options.jobs or [1000, 10_000, 100_000], options.seconds)
        else:
            workers = options.workers if len(options.workers) > 1 else [1, 2]
            counts = options.jobs or [125, 250, 500, 1000, 2000]
            rows = growth(folder, options.plot, counts, workers, options.preset, options.longer)
        print(markdown.table(Table("Speed of batches", ("what", "measured"), [*rows])))
    return 0


if __name__ == "__main__":
    sys.exit(main())
