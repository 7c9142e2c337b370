"""Frames per second of Ng and Delp's tracker on a part of one core, with little memory.

    sudo python benchmarks/slow_core.py                          # 10 % of a core, 128 MB
    sudo python benchmarks/slow_core.py --share 0.05 --memory 96

Needs Linux and the right to make control groups (version 1 or 2). The kernel enforces the limits:
a process gets its share of every 10 ms, and one that needs more memory ends.

Each variant decodes a rendered film and follows its target, in a process of its own. The first
frames are not counted, since the program starts in them. The variants are measured in turn.
"""

from __future__ import annotations

import argparse
import contextlib
import os
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path
from statistics import median
from tempfile import TemporaryDirectory
from typing import NamedTuple

import msgspec
from msgspec.structs import replace

from motes import Tracker
from motes.cues.sampling import Checkerboard, EveryPixel, Sampling
from motes.sot.particle_filter import ParticleFilter
from motes.sot.presets import NG_DELP
from motes.synthetic.clips import still
from motes.video.sources import open_source
from motes.video.writer import VideoWriter
from motes_lab.report import markdown
from motes_lab.report.tables import Cell, Row, Table

FILMS = {
    "352x240, a target of 10x30": ((352, 240), (10, 30)),  # the film of figure 4
    "640x480, a target of 60x100": ((640, 480), (60, 100)),
}
PIXELS: dict[str, Sampling | None] = {
    "all": EveryPixel(),
    "half": Checkerboard(share="half"),
    "quarter": Checkerboard(share="quarter"),
    "lattice, as shipped": None,
}
CUES = ("color and edges", "color", "edges")
PERIOD = 10_000
"""Microseconds in which a process gets its share; with a longer period it runs in bursts."""
STARTING_FRAMES, FRAMES = 10, 210
ROUNDS = 3
TOO_LITTLE_MEMORY = -9


class Run(NamedTuple):
    """A run of a variant: frames and processor seconds per frame, and the largest memory in KB."""

    frames_per_second: float
    seconds: float
    memory: int


def config_of(pixels: str, cues: str) -> ParticleFilter:
    """Return a variant of preset ng_delp."""
    assert NG_DELP.color is not None
    assert NG_DELP.edges is not None
    color, edges = NG_DELP.color, NG_DELP.edges
    if sampling := PIXELS[pixels]:
        color, edges = replace(color, sampling=sampling), replace(edges, sampling=sampling)
    # The background is measured once, at the start, at fewer places: it is no part of a frame.
    presence = replace(NG_DELP.presence, max_positions=1000)
    return replace(
        NG_DELP,
        color=None if cues == "edges" else color,
        edges=None if cues == "color" else edges,
        presence=presence,
    )


def follow(film: str, target: tuple[float, ...], pixels: str, cues: str) -> Run:
    """Follow the target through a film and return the figures of this process."""
    tracker = Tracker(config_of(pixels, cues))
    wall = processor = 0.0
    with open_source(film) as source:
        for frame in source:
            if frame.index == STARTING_FRAMES:
                wall, processor = time.perf_counter(), time.process_time()
            if frame.index == 0:
                tracker.init(frame, target)
            else:
                tracker.update(frame)
    frames = FRAMES - STARTING_FRAMES
    status = Path("/proc/self/status").read_text()
    (memory,) = (int(line.split()[1]) for line in status.splitlines() if line[:5] == "VmHWM")
    seconds = (time.process_time() - processor) / frames
    return Run(frames / (time.perf_counter() - wall), seconds, memory)


@contextlib.contextmanager
def limited(
    share: float, megabytes: int, root: Path = Path("/sys/fs/cgroup")
) -> Iterator[list[Path]]:
    """Make control groups with a share of one core and this much memory; yield their folders."""
    name = f"motes-{os.getpid()}"
    quota, most = int(PERIOD * share), megabytes << 20
    if (root / "cgroup.controllers").is_file():
        groups = [root / name]
        limits = {
            groups[0] / "cpu.max": f"{quota} {PERIOD}",
            groups[0] / "cpu.weight": "10000",  # others on a busy machine do not take its part
            groups[0] / "memory.max": str(most),
            groups[0] / "memory.swap.max": "0",
        }
    else:
        groups = [root / "cpu" / name, root / "memory" / name]
        limits = {
            groups[0] / "cpu.cfs_period_us": str(PERIOD),
            groups[0] / "cpu.cfs_quota_us": str(quota),
            groups[0] / "cpu.shares": "100000",
            groups[1] / "memory.limit_in_bytes": str(most),
        }
    try:
        try:
            for group in groups:
                group.mkdir()
            for file, value in limits.items():
                file.write_text(value)
        except OSError as error:
            sys.exit(f"No control group can be made ({error}); run this as root, on Linux.")
        yield groups
    finally:
        for group in groups:
            with contextlib.suppress(OSError):
                group.rmdir()


def run_limited(groups: list[Path], film: Path, target: str, pixels: str, cues: str) -> Run | None:
    """Follow the target in a process in control groups; None if its memory was not enough."""
    command = [sys.executable, __file__, "--follow", str(film), target, pixels, cues]
    done = subprocess.run(
        command,
        stdout=subprocess.PIPE,
        preexec_fn=lambda: [(group / "cgroup.procs").write_text("0") for group in groups],
        check=False,
    )
    if done.returncode == TOO_LITTLE_MEMORY:
        return None
    done.check_returncode()
    return msgspec.json.decode(done.stdout, type=Run)


def rows_of(runs: dict[tuple[str, str], list[Run | None]]) -> Iterator[Row]:
    """Yield the row of each variant, medians over its runs."""
    for (pixels, cues), found in runs.items():
        whole = [run for run in found if run is not None]
        if len(whole) < len(found):
            yield Cell(cues), Cell(pixels), Cell("not enough memory"), Cell(""), Cell("")
            continue
        rates = [run.frames_per_second for run in whole]
        yield (
            Cell(cues),
            Cell(pixels),
            Cell(f"{median(rates):.1f} ({min(rates):.1f} to {max(rates):.1f})"),
            Cell(f"{1000 * median(run.seconds for run in whole):.2f}"),
            Cell(f"{max(run.memory for run in whole) / 1024:.0f}"),
        )


def main() -> None:
    options = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    options.add_argument("--share", type=float, default=0.1, help="share of one core")
    options.add_argument("--memory", type=int, default=128, help="megabytes")
    options.add_argument("--rounds", type=int, default=ROUNDS)
    given = options.parse_args()
    with limited(given.share, given.memory) as groups, TemporaryDirectory() as folder:
        for title, (size, target) in FILMS.items():
            film = Path(folder) / "film.mp4"
            clip = still(size, target, FRAMES)
            with VideoWriter(film, 25) as writer:
                for frame, _ in clip:
                    writer.write(frame.pixels)
            region = ",".join(map(str, clip[0][1][0].ellipse))
            runs: dict[tuple[str, str], list[Run | None]] = {}
            for _ in range(given.rounds):
                for cues in CUES:
                    for pixels in PIXELS:
                        run = run_limited(groups, film, region, pixels, cues)
                        runs.setdefault((pixels, cues), []).append(run)
                        print(title, cues, pixels, run, file=sys.stderr)
            head = ("cues", "pixels", "frames per second", "ms of processor a frame", "MB")
            where = f"{100 * given.share:g} % of a core, {given.memory} MB: {title}"
            print(markdown.table(Table(where, head, list(rows_of(runs)))), end="\n\n", flush=True)
            film.unlink()


if __name__ == "__main__":
    if sys.argv[1:2] == ["--follow"]:
        film, region, pixels, cues = sys.argv[2:]
        numbers = tuple(float(number) for number in region.split(","))
        print(msgspec.json.encode(follow(film, numbers, pixels, cues)).decode())
    else:
        main()
